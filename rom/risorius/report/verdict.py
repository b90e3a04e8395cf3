"""Sentences on where a simpler method wins, and where a method is of no use, from the figures alone."""

from __future__ import annotations

from collections.abc import Iterator

from risorius.report.results import Results, Row

# Medians that are closer than this are the same: a machine does not repeat them any better.
SAME_TIME = 1.05
# An error that is larger by no more than this buys nothing that anybody would see.
SAME_ERROR = 1.10
MEASURES = {"mean": "mean", "95 %": "p95", "largest": "maximum"}


def verdict(results: Results) -> list[str]:
    """For every held-out set: what is most accurate, which simpler methods win over which, what is beaten in both."""
    sentences = []
    for held_out in results.sets:
        rows = results.of(held_out)
        sentences.append(_best(rows, results))
        sentences += _simpler_wins(rows)
        sentences += _beaten(rows)
    return sentences


def _best(rows: tuple[Row, ...], results: Results) -> str:
    best = min(rows, key=lambda row: row.errors.p95)
    text = (
        f"{_capital(best.held_out)} input: {best.method} is the most accurate, 95 % of the vertices within "
        f"{_mm(best.errors.p95)} mm, in {_us(best.frame.median)} µs a frame"
    )
    full = results.full.get(best.held_out)
    return (
        f"{text}, {_count(full.seconds / best.frame.median)} times as fast as the full model." if full else f"{text}."
    )


def _simpler_wins(rows: tuple[Row, ...]) -> Iterator[str]:
    """One sentence for each method that a simpler one does not lose to in some measure, while it is not slower."""
    for row in rows:
        simpler = [one for one in rows if one.family.simplicity < row.family.simplicity and _not_slower(one, row)]
        won = {one.method: [name for name, field in MEASURES.items() if _as_good(one, row, field)] for one in simpler}
        if not any(won.values()):
            continue
        winner = max(simpler, key=lambda one: len(won[one.method]))
        measures = _listed(won[winner.method])
        yield (
            f"{_capital(row.held_out)} input: a simpler method wins: {winner.method} is as fast as {row.method} or "
            f"faster, and no worse in the {measures} error "
            f"(mean {_mm(winner.errors.mean)} against {_mm(row.errors.mean)} mm, "
            f"95 % {_mm(winner.errors.p95)} against {_mm(row.errors.p95)}, "
            f"largest {_mm(winner.errors.maximum)} against {_mm(row.errors.maximum)})."
        )


def _beaten(rows: tuple[Row, ...]) -> Iterator[str]:
    """One sentence for each method that another, no simpler one beats in 95 % error and in time."""
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
                f"{_capital(row.held_out)} input: {one.method} beats {row.method} in error and time, "
                f"95 % {_mm(one.errors.p95)} against {_mm(row.errors.p95)} mm in "
                f"{_us(one.frame.median)} against {_us(row.frame.median)} µs a frame."
            )


def _not_slower(one: Row, other: Row) -> bool:
    return one.frame.median <= SAME_TIME * other.frame.median


def _as_good(one: Row, other: Row, field: str) -> bool:
    return bool(getattr(one.errors, field) <= SAME_ERROR * getattr(other.errors, field))


def _listed(names: list[str]) -> str:
    return " and ".join(filter(None, [", ".join(names[:-1]), names[-1]]))


def _capital(name: str) -> str:
    return name[:1].upper() + name[1:]


def _mm(metres: float) -> str:
    return f"{1e3 * metres:.3g}"


def _us(seconds: float) -> str:
    return f"{1e6 * seconds:.3g}" if seconds < 1e-3 else f"{1e6 * seconds:,.0f}".replace(",", " ")


def _count(number: float) -> str:
    return f"{float(f'{number:.2g}'):,.0f}".replace(",", " ")
