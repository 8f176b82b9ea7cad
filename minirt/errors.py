"""The exceptions of minirt: each says what is wrong, where, what was found and expected."""

from __future__ import annotations


class MinirtError(Exception):
    """A request that minirt cannot carry out; the base of all its exceptions.

    Parameters
    ----------
    what : str
        What is wrong, in one sentence without a full stop.
    where : str
        The file, JSON path, argument or scene that it concerns; empty for none.
    got, expected : str
        What was found, and what would be right; empty where the sentence says it all.

    Attributes
    ----------
    exit_status : int
        The exit status of a command that ends with this error.

    Examples
    --------
    >>> str(MinirtError("wrong size", where="a.exr", got="2 × 2", expected="4 × 4"))
    'a.exr: wrong size; got 2 × 2; expected 4 × 4'
    """

    exit_status = 2

    def __init__(self, what: str, *, where: str = "", got: str = "", expected: str = "") -> None:
        super().__init__(what, where, got, expected)
        self.what = what
        self.where = where
        self.got = got
        self.expected = expected

    def __str__(self) -> str:
        text = f"{self.where}: {self.what}" if self.where else self.what
        if self.got:
            text += f"; got {self.got}"
        if self.expected:
            text += f"; expected {self.expected}"
        return text

    def __reduce__(self) -> tuple[object, ...]:
        return _rebuild, (type(self), self.what, self.where, self.got, self.expected)


class SceneError(MinirtError):
    """A scene, or a mesh file that it names, does not follow the format."""


class InputError(MinirtError):
    """An argument, or an input file other than a scene, cannot be used."""


class NotInFrame(InputError, KeyError):
    """A quantity that a frame does not hold; also a `KeyError`, since a frame is a mapping."""


class ReferenceError(MinirtError):
    """A reference renderer or program that was required is missing, crashed or timed out."""

    exit_status = 3


def _rebuild(
    kind: type[MinirtError], what: str, where: str, got: str, expected: str
) -> MinirtError:
    return kind(what, where=where, got=got, expected=expected)
