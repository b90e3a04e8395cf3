"""The table of hard cases: one line for each, and a summary."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from risorius_offline.equilibrium import EquilibriumSolver
from tests.offline.hard_attempts import REFUSED, Attempt, HardCase, attempt, check, is_stable

INTRODUCTION = (
    "# Hard cases\n{summary}\n\n"
    "Each is solved in one call, from rest unless it says otherwise. Where it converges, a fresh model confirms, "
    "whatever the report of the solver says, that\n"
    "displacements are finite, that J > 0 everywhere, and that the residual at the parameters asked for,\n"
    "norm of free forces over that of muscle and reaction forces, is at most 1e-6. *Smallest J* is a lower bound over "
    "whole cells, from the Bernstein coefficients of their determinants (`jacobian_bounds.py`). Where it is refused, "
    "the error is `NotConvergedError` and its report has not converged.\n"
    "*Stable*: the second derivatives of the energy are positive definite there, so the state is a minimum. *Seconds* "
    "are those of one solve, of the start too where it is not rest, with building the model.\n\n"
    "Slabs are cheeks of 30 x 30 x 15 mm, of four layers, with muscles of 20 kPa in the second from below; columns are "
    "20 x 20 x 30 mm. The curved cheek (40 x 40 x 12 mm, four layers, six muscles of 100 kPa, skull and jaw) and the "
    "mouth (a slit sheet, 40 x 32 x 6 mm, before teeth) are harder. The table is written by\n"
    "```\npython -m tests.offline.hard_cases -o docs/hard_cases.md\n```\n"
    "and tested by `tests/offline/test_hard_cases.py`; there the published face is among the slow tests, without its "
    "action units against bones.\n\n"
)
FINDINGS = (
    "\n## What falls short\n"
    "- From jaw and all muscles at 1 back to rest in a single step is refused: the straight way of the bones inverts "
    "cells. With load steps it arrives. Muscles at -0.1 are refused too: stretching then releases energy without end.\n"
    "- The column of 30 mm whose end is pushed through its base has no state with J > 0 everywhere that the solver "
    "reaches: it is refused beyond a third of the way.\n"
    "- Without contact nothing sees surfaces that cross.\n"
)
COLUMNS = (
    "case",
    "degrees of freedom",
    "outcome",
    "iterations",
    "factorisations",
    "load steps (rejected)",
    "smallest J",
    "residual",
    "stable",
    "seconds",
)


@dataclass(frozen=True)
class Row:
    """A line of the table; whether the case did as expected, and whether it converged to what is no minimum."""

    text: str
    outcome: str
    expected: bool
    unstable: bool


def row(case: HardCase) -> Row:
    """Solve a case, check it and tell of it."""
    tried = attempt(case)
    if tried.found is None:
        return Row(_line(case, tried, "-", "-", "-"), REFUSED, case.expect == REFUSED, False)
    model = case.build()
    judged, stable = check(case, model, tried.found), is_stable(model, tried.found.u)
    holds = judged.finite and judged.smallest_jacobian > 0.0 and judged.residual <= EquilibriumSolver.tolerance
    text = _line(
        case,
        tried,
        f"{judged.smallest_jacobian:.3f}",
        f"{judged.residual:.1e}",
        "yes" if stable else "**no**",
    )
    return Row(text, tried.outcome, holds and case.expect == tried.outcome, not stable)


def _line(case: HardCase, tried: Attempt, smallest: str, residual: str, stable: str) -> str:
    report = tried.report
    outcome = tried.outcome if tried.outcome == case.expect else f"**{tried.outcome}**, not expected"
    return (
        f"| {case.name} | {tried.degrees_of_freedom} | {outcome} | {report.iterations} | {report.factorisations} "
        f"| {report.steps} ({report.rejected_steps}) | {smallest} | {residual} | {stable} | {tried.seconds:.1f} |"
    )


def document(rows: Sequence[Row]) -> str:
    """The whole page."""
    refused = sum(row.outcome == REFUSED for row in rows)
    unexpected, unstable = sum(not row.expected for row in rows), sum(row.unstable for row in rows)
    summary = (
        f"{len(rows)} cases: {len(rows) - refused} converge, {refused} are refused; {unexpected} are not as expected. "
        f"{unstable} converge to a state that is no minimum of the energy."
    )
    header = f"| {' | '.join(COLUMNS)} |\n{'|---' * len(COLUMNS)}|\n"
    return INTRODUCTION.format(summary=summary) + header + "\n".join(row.text for row in rows) + "\n" + FINDINGS
