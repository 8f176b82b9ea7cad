"""One tree of errors: what is wrong, where, what was found and what would be right."""

from __future__ import annotations


class MinirtError(Exception):
    """Something minirt was asked for cannot be done; nothing was changed.

    Parameters
    ----------
    what : str
        What is wrong, in one sentence without a full stop.
    where : str
        The file, JSON path, argument or scene it concerns; empty where there is none.
    got, expected : str
        What was found, and what would be right; empty where the sentence says it all.
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
    """A scene, or a file that it names, is not what the format asks for."""


class InputError(MinirtError):
    """An argument or an input file that is not a scene cannot be used."""


class NotInFrame(InputError, KeyError):
    """A quantity that a frame does not hold; a `KeyError` too, since a frame is a mapping."""


class ReferenceError(MinirtError):
    """A reference renderer or program that was required is missing, crashed or timed out."""

    exit_status = 3


def _rebuild(
    kind: type[MinirtError], what: str, where: str, got: str, expected: str
) -> MinirtError:
    return kind(what, where=where, got=got, expected=expected)
