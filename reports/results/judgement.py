"""What the judge said, for the reports: in words, and as a record of `results.json`."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence

from pydantic import Field

from reference.exact import Judgement, Opinion
from reference.verify.results import SceneResult
from reports.results.json_model import Model, Natural, Number
from reports.results.words import count, number, values

#: Convictions that `results.json` lists of a scene; their number is always given.
MOST_LISTED = 20


class OpinionModel(Model):
    """One quantity of one pixel where minirt does not have the exact answer."""

    quantity: str
    column: Natural = Field(description="from the left")
    row: Natural = Field(description="from the top")
    ours: list[Number]
    exact: list[Number]
    ulps: Number | None = Field(description="error in ulp of the bound; null for a discrete one")


class CountModel(Model):
    """One quantity over the pixels that were judged."""

    quantity: str
    judged: Natural = Field(description="pixels where it applies")
    decided: Natural = Field(description="of those, where the exact answer is certain")
    agreed: Natural = Field(description="of those, where minirt has it")
    ulps: Number | None = Field(description="largest error in ulp of the bound; 4 are allowed")


class JudgementModel(Model):
    """minirt against exact arithmetic on one scene."""

    pixels: Natural
    seconds: float
    counts: list[CountModel]
    convicted: Natural = Field(description="answers that are certain and that minirt has not")
    convictions: list[OpinionModel] = Field(description=f"the first {MOST_LISTED}")


def judgement_model(judgement: Judgement | None) -> JudgementModel | None:
    """The record of a judgement."""
    if judgement is None:
        return None
    return JudgementModel(
        pixels=judgement.pixels,
        seconds=judgement.seconds,
        counts=[CountModel(**vars(each)) for each in judgement.counts],
        convicted=len(judgement.convictions),
        convictions=[_opinion(each) for each in judgement.convictions[:MOST_LISTED]],
    )


def convicted(results: Iterable[SceneResult]) -> Iterator[SceneResult]:
    """Scenes on which the judge convicts minirt."""
    for result in results:
        if result.judgement is not None and result.judgement.convictions:
            yield result


def judgement_in_words(judgement: Judgement) -> str:
    """The judgement in a sentence."""
    decided = sum(each.decided for each in judgement.counts)
    if judgement.convictions:
        first = judgement.convictions[0]
        return (
            f"convicts minirt: {_answers(len(judgement.convictions))} of {decided} wrong, "
            f"first {opinion_in_words(first)}"
        )
    judged = sum(each.judged for each in judgement.counts)
    worst = judgement.worst.ulps if judgement.worst is not None else None
    error = "" if worst is None else f", t within {number(worst or 0.0)} ulp of its condition"
    return (
        f"confirms minirt: {decided} of {_answers(judged)} at "
        f"{count(judgement.pixels, 'pixel')} are certain and right{error}"
    )


def all_in_words(judgements: Sequence[Judgement]) -> str:
    """All judgements of a run that convict nothing, in a clause; empty where there is none."""
    decided = sum(each.decided for judgement in judgements for each in judgement.counts)
    return f"exact arithmetic confirms {_answers(decided)}" if decided else ""


def opinion_in_words(opinion: Opinion) -> str:
    """Quantity, pixel and both values."""
    ours, exact = (values(opinion.quantity, list(v)) for v in (opinion.ours, opinion.exact))
    place = f"{opinion.quantity} at ({opinion.column}, {opinion.row})"
    return f"{place}: ours {ours}, exact {exact}"


def _opinion(opinion: Opinion) -> OpinionModel:
    return OpinionModel(
        quantity=opinion.quantity,
        column=opinion.column,
        row=opinion.row,
        ours=list(opinion.ours),
        exact=list(opinion.exact),
        ulps=opinion.ulps,
    )


def _answers(n: int) -> str:
    return f"{n:,} answer" + ("" if n == 1 else "s")
