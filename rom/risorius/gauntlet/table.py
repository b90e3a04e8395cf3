"""Results for people and for programs."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Sequence
from dataclasses import asdict

from rich.table import Table

from risorius.gauntlet.judge import VERDICTS
from risorius.gauntlet.run import FAILED, NOT_APPLICABLE, PASSED, Result

COLOURS = {PASSED: "green", FAILED: "bold red", NOT_APPLICABLE: "dim"}


def as_table(results: Sequence[Result]) -> Table:
    """One line for each case."""
    table = Table(title=summary(results))
    for column in ("group", "case", "verdict"):
        table.add_column(column, overflow="fold")
    for column in ("frames", "refused", "mended", "held", "went back", "smallest J", "farthest, mm", "deepest, mm"):
        table.add_column(column, justify="right", no_wrap=True)
    table.add_column("what does not hold, or is not there", overflow="fold")
    for one in results:
        verdict = f"[{COLOURS[one.outcome]}]{one.outcome}[/]"
        table.add_row(one.group, one.name, verdict, *_figures(one), one.detail)
    return table


def _figures(one: Result) -> list[str]:
    if one.outcome == NOT_APPLICABLE:
        return ["-"] * 8
    smallest = "-" if one.smallest_jacobian is None else f"{one.smallest_jacobian:.3f}"
    counts = (one.frames, one.refused, one.mended, one.held, one.went_back)
    return [*map(str, counts), smallest, f"{1e3 * one.farthest:.1f}", f"{1e3 * one.deepest:.2f}"]


def summary(results: Sequence[Result]) -> str:
    """Outcomes in one sentence."""
    counts = Counter(one.outcome for one in results)
    return f"{len(results)} cases: {counts[PASSED]} passed, {counts[FAILED]} failed, " + (
        f"{counts[NOT_APPLICABLE]} not applicable to this model"
    )


def as_json(model: str, results: Sequence[Result]) -> str:
    """The same with what each verdict means; lengths in metres."""
    content = {"model": model, "verdicts": VERDICTS, "cases": [asdict(one) for one in results]}
    return json.dumps(content, indent=2)
