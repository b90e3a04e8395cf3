"""`risorius report` with EZyRB and pyMOR among the methods: same snapshots, same rank, frames in turn; one thread.

python benchmarks/reduced_model_peers.py model.h5 --snapshots FILE [--anatomy SOURCE] [-o report]

In an environment of its own: pip install '.[offline,report]' ezyrb pymor
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from peers import one_thread  # noqa: F401  before all that starts threads

# isort: split

from peers import ezyrb_map, pymor_map
from peers.snapshot_fields import SnapshotFields

import risorius
from risorius.report.files import require_folder, write
from risorius.report.measurement import Tried, measure
from risorius.report.verdict import verdict
from risorius.snapshot_file import solve_seconds


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("model", type=Path)
    parser.add_argument("--snapshots", type=Path, required=True)
    parser.add_argument("--anatomy")
    parser.add_argument("-o", "--output", type=Path, default=Path("report"))
    options = parser.parse_args()
    require_folder(options.output)
    model = risorius.load(options.model)
    tried = Tried.of(options.snapshots, model)
    fields = SnapshotFields.of(tried.snapshots, model)
    solves = float(solve_seconds(options.snapshots)[~tried.snapshots.held_out].sum())
    peers = [peer.candidate(fields, solves) for peer in (ezyrb_map, pymor_map)]
    results = measure(model, tried, options.anatomy, peers)
    write(results, options.output)
    print("\n".join(verdict(results)))
    return 0


if __name__ == "__main__":
    sys.exit(main())
