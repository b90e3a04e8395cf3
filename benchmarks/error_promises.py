"""Whether errors are what was promised: benchmarks/error_promises.py MODEL SNAPSHOTS [--divisions 60] [--new].

A frame states a bound of its error, and an engine takes the point that keeps the error asked for: both are calibrated
on held-out snapshots. Here on four fifths of them, and counted on the fifth that is left, in as many divisions as asked
for; or, of snapshots that are new to the model (another seed), what the model itself states. For each operating point,
effects on: the share of frames whose bound covers their largest error, the median of bound / error, and the share of
frames that keep the error that the point promises.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np
from rich.console import Console
from rich.table import Table

import risorius
from risorius.accuracy import HeldOut, conformal_quantile
from risorius.error_bound import ErrorBound
from risorius.operating_point import OperatingPoint
from risorius.pipeline import Pipeline, pipelines
from risorius.snapshot_file import SnapshotSet

PARTS = 5


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("model", type=Path)
    parser.add_argument("snapshots", type=Path)
    parser.add_argument("--divisions", type=int, default=60)
    parser.add_argument("--new", action="store_true")
    options = parser.parse_args()
    model, held = risorius.load(options.model), HeldOut.of(SnapshotSet.load(options.snapshots))
    kinds = np.array(held.kinds)
    groups = {"all": kinds == kinds} | {kind: kinds == kind for kind in dict.fromkeys(held.kinds)}
    table = Table("operating point", "frames", "bound covers, %", "bound / error", "budget kept, %")
    ways = pipelines(model, [point.setting for point in model.points], tuple(model.effects.values()))
    for point, way in zip(model.points, ways, strict=True):
        indicators, errors = answers(model, held, way)
        if options.new:
            counted = stated(point, indicators, errors)
        else:
            counted = divided(indicators, errors, kinds, options.divisions)
        for name, rows in groups.items():
            covered, ratio, kept = (values[:, rows] for values in counted)
            shares = 100.0 * np.nanmean(covered), np.nanmedian(ratio), 100.0 * np.nanmean(kept)
            table.add_row(str(point.setting), name, *(f"{share:.1f}" for share in shares))
    Console(width=140).print(table)


def answers(model: risorius.ReducedModel, held: HeldOut, way: Pipeline) -> tuple[np.ndarray, np.ndarray]:
    """Indicators (h, 4) and largest errors (h,), metres, of all held-out snapshots."""
    vertices, indicators, errors = np.empty_like(model.rest_vertices), [], []
    for parameters, truth in zip(held.parameters, held.displacements, strict=True):
        indicators.append(way.solve(parameters))
        way.write(vertices)
        errors.append(np.linalg.norm(vertices - model.rest_vertices - truth, axis=1).max())
    return np.array(indicators), np.array(errors, dtype=np.float64)


def stated(
    point: OperatingPoint, indicators: np.ndarray, errors: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """As `divided`, (1, h), by the bound and the promise of an operating point."""
    bounds = np.array([point.bound.value(tuple(row)) for row in indicators])
    return (bounds >= errors)[None], (bounds / errors)[None], (errors <= point.frame_error)[None]


def divided(
    indicators: np.ndarray, errors: np.ndarray, kinds: np.ndarray, divisions: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Of every division (d, h): whether the bound covers, bound / error, whether the budget is kept; NaN if seen."""
    rng = np.random.default_rng(0)
    covered, ratio, kept = (np.full((divisions, len(errors)), np.nan) for _ in range(3))
    for number in range(divisions):
        unseen = np.zeros(len(errors), bool)
        for kind in dict.fromkeys(kinds):
            rows = rng.permutation(np.flatnonzero(kinds == kind))
            unseen[rows[: max(1, len(rows) // PARTS)]] = True
        bound = ErrorBound.fit(indicators[~unseen], errors[~unseen])
        promised = max(conformal_quantile(errors[~unseen & (kinds == kind)]) for kind in dict.fromkeys(kinds))
        for row in np.flatnonzero(unseen):
            stated = bound.value(tuple(indicators[row]))
            covered[number, row], ratio[number, row] = stated >= errors[row], stated / errors[row]
            kept[number, row] = errors[row] <= promised
    return covered, ratio, kept


if __name__ == "__main__":
    main()
