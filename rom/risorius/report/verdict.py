"""Sentences on what is best, where a simpler method wins and which is of no use, from the figures alone."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from risorius.report.continued import CONTINUED
from risorius.report.results import Results, Row

# Medians that are closer than this are the same: a machine does not repeat them any better.
SAME_TIME = 1.05
# An error that is larger by no more than this buys nothing that anybody would see.
SAME_ERROR = 1.10
MEASURES = {"mean": "mean", "95 %": "p95", "largest": "maximum"}


def verdict(results: Results) -> list[str]:
    """For every held-out set: what is most accurate, which simpler methods win, which are beaten in error and time."""
    sentences = []
    for held_out in results.sets:
        online = [row for row in results.of(held_out) if row.family is not CONTINUED]
        later = [row for row in results.of(held_out) if row.family is CONTINUED]
        methods = _one_of_each(online)
        found = [_best(online, results), *_simpler_wins(methods), *_beaten(methods), *_continued(later)]
        sentences += [f"{held_out[:1].upper()}{held_out[1:]} input: {text}" for text in found]
    return sentences


def _one_of_each(rows: Sequence[Row]) -> list[Row]:
    """For each method the fastest operating point that is as good as its best."""
    found = []
    for method in dict.fromkeys(row.method for row in rows):
        own = [row for row in rows if row.method == method]
        least = min(row.errors.p95 for row in own)
        enough = [row for row in own if row.errors.p95 <= SAME_ERROR * least]
        found.append(min(enough, key=lambda row: row.frame.median))
    return found


def _best(rows: Sequence[Row], results: Results) -> str:
    best = min(rows, key=lambda row: row.errors.p95)
    text = (
        f"most accurate is {best.name}, with 95 % of the vertices within {_mm(best.errors.p95)} mm, "
        f"in {_us(best.frame.median)} µs a frame"
    )
    full = results.full.get(best.held_out)
    if full is None:
        return f"{text}."
    return f"{text}; the full model takes {_count(full.seconds / best.frame.median)} times as long."


def _continued(rows: Sequence[Row]) -> Iterator[str]:
    """One sentence on what the full model, going on from the map, buys."""
    if rows:
        bought = ", ".join(f"{_mm(row.errors.p95)} mm in {_count(1e3 * row.frame.median)} ms" for row in rows)
        yield f"the full model that goes on from the map's answer is within, 95 %, {bought}."


def _simpler_wins(rows: Sequence[Row]) -> Iterator[str]:
    """One sentence for each method that a simpler one, not slower, does not lose to in some measure."""
    for row in rows:
        simpler = [one for one in rows if one.family.simplicity < row.family.simplicity and _not_slower(one, row)]
        won = {one.name: [name for name, field in MEASURES.items() if _as_good(one, row, field)] for one in simpler}
        if not any(won.values()):
            continue
        winner = max(simpler, key=lambda one: len(won[one.name]))
        yield (
            f"a simpler method wins: {winner.name}, not slower than {row.name}, is no worse in the "
            f"{_listed(won[winner.name])} error (mean {_against(winner, row, 'mean')} mm, "
            f"95 % {_against(winner, row, 'p95')}, largest {_against(winner, row, 'maximum')})."
        )


def _beaten(rows: Sequence[Row]) -> Iterator[str]:
    """One sentence for each method that another, which is not simpler, beats in 95 % error and in time."""
    for row in rows:
        better = [
            one
            for one in rows
            if one.family.simplicity >= row.family.simplicity
            and one.errors.p95 < row.errors.p95
            and one.frame.median * SAME_TIME < row.frame.median
        ]
        if better:
            one = min(better, key=lambda found: found.errors.p95)
            yield (
                f"{one.name} beats {row.name} in error and time, 95 % {_against(one, row, 'p95')} mm "
                f"in {_us(one.frame.median)} against {_us(row.frame.median)} µs a frame."
            )


def _not_slower(one: Row, other: Row) -> bool:
    return one.frame.median <= SAME_TIME * other.frame.median


def _as_good(one: Row, other: Row, field: str) -> bool:
    return bool(getattr(one.errors, field) <= SAME_ERROR * getattr(other.errors, field))


def _against(one: Row, other: Row, field: str) -> str:
    return f"{_mm(getattr(one.errors, field))} against {_mm(getattr(other.errors, field))}"


def _listed(names: Sequence[str]) -> str:
    return " and ".join(filter(None, [", ".join(names[:-1]), names[-1]]))


def _mm(metres: float) -> str:
    return f"{1e3 * metres:.3g}" if metres >= 1e-6 else "0.001"


def _us(seconds: float) -> str:
    return f"{1e6 * seconds:.3g}" if seconds < 1e-3 else f"{1e6 * seconds:,.0f}".replace(",", "\N{NO-BREAK SPACE}")


def _count(number: float) -> str:
    """Two digits: more would not come out again."""
    return f"{float(f'{number:.2g}'):,.0f}".replace(",", "\N{NO-BREAK SPACE}")
