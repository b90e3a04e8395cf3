"""The table as CSV and JSON, in SI units."""

from __future__ import annotations

import csv
import io
import json
from dataclasses import asdict
from typing import Any

from risorius.report.results import Results, Row, front


def records(results: Results) -> list[dict[str, Any]]:
    """One flat record for each operating point and held-out set; lengths in metres, times in seconds.

    front_coordinates, front_frame: on the Pareto front of the 95 % error against the median of that time.
    """
    found = []
    for held_out in results.sets:
        rows = results.of(held_out)
        by_coordinates = front([(row.coordinates.median, row.errors.p95) for row in rows])
        by_frame = front([(row.frame.median, row.errors.p95) for row in rows])
        found += [
            {**_record(row), "front_coordinates": fast, "front_frame": on_front}
            for row, fast, on_front in zip(rows, by_coordinates, by_frame, strict=True)
        ]
    return found


def _record(row: Row) -> dict[str, Any]:
    return {
        "operating_point": row.name,
        "method": row.method,
        "family": row.family.name,
        "held_out": row.held_out,
        "error_mean_m": row.errors.mean,
        "error_p95_m": row.errors.p95,
        "error_max_m": row.errors.maximum,
        "relative_l2_median": row.errors.relative,
        "coordinates_median_s": row.coordinates.median,
        "coordinates_p99_s": row.coordinates.p99,
        "frame_median_s": row.frame.median,
        "frame_p99_s": row.frame.p99,
        "snapshots": row.offline.snapshots,
        "solves_cpu_s": row.offline.solves,
        "training_cpu_s": row.offline.training,
    }


def as_csv(results: Results) -> str:
    """Comma-separated values with a header; what is not known is empty."""
    rows = records(results)
    text = io.StringIO()
    writer = csv.DictWriter(text, fieldnames=list(rows[0]), lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    return text.getvalue()


def as_json(results: Results) -> str:
    """The same records, with the full model, the machine and where the figures come from."""
    content = {
        "model": results.model,
        "coordinates": results.rank,
        "vertices": results.vertices,
        "frames_timed": results.frames,
        "errors_from": results.errors_from,
        "times_from": results.times_from,
        "full_model": {name: asdict(time) for name, time in results.full.items()},
        "machine": asdict(results.machine),
        "operating_points": records(results),
    }
    return json.dumps(content, indent=2)
