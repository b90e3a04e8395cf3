"""Time to get the visible skin from reduced coordinates: the table of docs/skin_reconstruction.md.

    python benchmarks/skin_reconstruction.py SNAPSHOTS [--size SIZE ...] [-o FILE.csv]

SNAPSHOTS is a snapshot file of the built-in head, whose modes are interpolated to a head of SIZE, `standard` or `fine`.
All ways take turns in one process with one thread: again and again (warm), and after other memory was read (cold).
"""

from __future__ import annotations

import argparse
import csv
import time
from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path

from peers import one_thread  # noqa: F401  before all that starts threads

# isort: split

import numba
import numpy as np
from rich.console import Console
from rich.table import Table
from skin_data import Modes

from risorius.carried_basis import CarriedBasis
from risorius.jaw import FloatArray
from risorius.normals import vertex_normals
from risorius.reconstruction import CarriedReconstruction, PlainReconstruction, Vertices
from risorius.vector_sums import carry

MODES = (80, 120, 160)
ROUNDS, WARM, COLD = 8, 50, 8  # calls of every way in a round
OTHER_MEMORY = np.zeros(24 << 20, np.uint8)
BLOCK = 64  # components with a scale of their own


@dataclass(frozen=True)
class Row:
    """Times in microseconds; read: megabytes; error: micrometres, largest of a vertex in a tenth of the snapshots."""

    vertices: int
    coordinates: int
    way: str
    median: float
    p99: float
    cold: float
    read: float
    error: float


class Quantised:
    """Sixteen-bit fields with a scale for every coordinate and block of components."""

    def __init__(self, fields: FloatArray) -> None:
        count, size = fields.shape
        padded = np.zeros((-(-count // 8) * 8, -(-size // BLOCK) * BLOCK))
        padded[:count, :size] = fields
        blocks = padded.reshape(len(padded), -1, BLOCK).transpose(1, 0, 2)
        scales = np.maximum(np.abs(blocks).max(axis=2) / 32767, 1e-30)
        self._values = np.ascontiguousarray(np.round(blocks / scales[..., None]).astype(np.int16))
        self._scales = scales.astype(np.float32)
        self._coordinates = np.zeros(len(padded), np.float32)
        self._scaled, self._sums = np.empty(len(padded), np.float32), np.empty(BLOCK, np.float32)
        self.out = np.empty(padded.shape[1], np.float32)
        self.bytes_read = self._values.nbytes + self._scales.nbytes

    def add_up(self, coordinates: FloatArray) -> None:
        """Write the sum of the fields into `out`."""
        self._coordinates[: len(coordinates)] = coordinates
        _add_up(self._values, self._scales, self._coordinates, self._scaled, self._sums, self.out)


@numba.njit(fastmath={"contract", "reassoc", "nsz"})
def _add_up(values, scales, coordinates, q, sums, out):  # type: ignore[no-untyped-def]
    for block in range(len(values)):
        v = values[block]
        for k in range(len(q)):
            q[k] = coordinates[k] * scales[block, k]
        sums[:] = 0.0
        for k in range(0, len(q), 8):
            q0, q1, q2, q3, q4, q5, q6, q7 = q[k], q[k + 1], q[k + 2], q[k + 3], q[k + 4], q[k + 5], q[k + 6], q[k + 7]
            for i in range(BLOCK):
                sums[i] += (
                    (q0 * np.float32(v[k, i]) + q1 * np.float32(v[k + 1, i]))
                    + (q2 * np.float32(v[k + 2, i]) + q3 * np.float32(v[k + 3, i]))
                    + (q4 * np.float32(v[k + 4, i]) + q5 * np.float32(v[k + 5, i]))
                    + (q6 * np.float32(v[k + 6, i]) + q7 * np.float32(v[k + 7, i]))
                )
        for i in range(BLOCK):
            out[block * BLOCK + i] = sums[i]


class QuantisedVertices:
    """Sixteen-bit fields of the vertices."""

    def __init__(self, basis: CarriedBasis, rest: Vertices) -> None:
        self._fields, self._rest = Quantised(basis.at_vertices().reshape(len(basis), -1)), rest.reshape(-1)
        self.bytes_read = self._fields.bytes_read + rest.nbytes

    def write(self, coordinates: FloatArray, out: Vertices) -> None:
        self._fields.add_up(coordinates)
        np.add(self._fields.out[: self._rest.size], self._rest, out=out.reshape(-1))


class QuantisedCarriers(CarriedReconstruction):
    """Sixteen-bit fields of the carrying points."""

    def __init__(self, basis: CarriedBasis, rest: Vertices) -> None:
        super().__init__(basis, rest)
        self._quantised = Quantised(basis.fields.reshape(len(basis), -1))
        self.bytes_read += self._quantised.bytes_read - self._fields.nbytes

    def write(self, coordinates: FloatArray, out: Vertices) -> None:
        self._quantised.add_up(coordinates)
        carry(*self._blocks, self._quantised.out, out.reshape(-1))


class Blas:
    """The product with the fields of the vertices that a BLAS makes."""

    def __init__(self, basis: CarriedBasis, rest: Vertices) -> None:
        self._fields, self._rest = basis.at_vertices().reshape(len(basis), -1), rest.reshape(-1)
        self.bytes_read = self._fields.nbytes + rest.nbytes

    def write(self, coordinates: FloatArray, out: Vertices) -> None:
        flat = out.reshape(-1)
        np.dot(coordinates.astype(np.float32), self._fields, out=flat)
        flat += self._rest


WAYS = {
    "BLAS at vertices": Blas,
    "packed at vertices": PlainReconstruction,
    "int16 at vertices": QuantisedVertices,
    "carried, int16": QuantisedCarriers,
    "carried": CarriedReconstruction,
}


def measure(modes: Modes, count: int) -> list[Row]:
    """All ways with lifts and `count` modes."""
    rank = len(modes.fields) - MODES[-1] + count
    basis, coordinates = modes.basis(rank), modes.coordinates[:, :rank]
    built = {name: way(basis, modes.rest) for name, way in WAYS.items()}
    out = np.empty_like(modes.rest)
    calls = {name: (lambda q, way=way: way.write(q, out)) for name, way in built.items()}
    triangles = modes.surface.triangles.astype(np.int32)
    normals = np.empty_like(out)
    calls["normals, besides"] = lambda q: vertex_normals(out, triangles, out=normals)
    read = {name: way.bytes_read for name, way in built.items()} | {"normals, besides": triangles.nbytes + out.nbytes}
    warm, cold = timed(calls, coordinates)
    return [
        Row(len(out), rank, name, float(np.median(warm[name])), float(np.quantile(warm[name], 0.99)),
            float(np.median(cold[name])), read[name] / 1e6, largest_error(built[name], basis, modes, coordinates)
            if name in built else float("nan"))
        for name in calls
    ]  # fmt: skip


def timed(calls: dict[str, Callable[[FloatArray], None]], coordinates: FloatArray) -> tuple[dict, dict]:
    """Microseconds of all calls with coordinates of snapshots drawn at random, warm and cold."""
    rng = np.random.default_rng(0)
    warm, cold = ({name: [] for name in calls} for _ in range(2))
    for call in calls.values():
        call(coordinates[0])  # compiles
    for _ in range(ROUNDS):
        for name, call in calls.items():
            for number in range(WARM + COLD):
                q = coordinates[rng.integers(len(coordinates))]
                if number >= WARM:
                    OTHER_MEMORY.sum()
                start = time.perf_counter()
                call(q)
                (warm if number < WARM else cold)[name].append(1e6 * (time.perf_counter() - start))
    return warm, cold


def largest_error(way, basis: CarriedBasis, modes: Modes, coordinates: FloatArray) -> float:
    out, worst = np.empty_like(modes.rest), 0.0
    fields = basis.fields.astype(np.float64)
    for q in coordinates[::10]:
        way.write(q, out)
        exact = modes.rest + basis.weights @ np.tensordot(q, fields, axes=1)
        worst = max(worst, float(np.linalg.norm(out - exact, axis=1).max()))
    return 1e6 * worst


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("snapshots", type=Path)
    parser.add_argument("--size", dest="sizes", action="append", choices=["standard", "fine"], default=[])
    parser.add_argument("-o", "--output", type=Path)
    arguments = parser.parse_args()
    own = Modes.of_snapshots(arguments.snapshots, MODES[-1])
    heads = [own, *(own.on_head(size) for size in arguments.sizes)]
    rows = [row for modes in heads for count in MODES for row in measure(modes, count)]
    table = Table("vertices", "coordinates", "way", "median, us", "p99, us", "cold, us", "read, MB", "error, um")
    for row in rows:
        figures = (f"{row.median:.0f}", f"{row.p99:.0f}", f"{row.cold:.0f}", f"{row.read:.1f}", f"{row.error:.3f}")
        table.add_row(str(row.vertices), str(row.coordinates), row.way, *figures)
    Console(width=120).print(table)
    if arguments.output:
        with arguments.output.open("w", newline="") as file:
            writer = csv.DictWriter(file, fieldnames=list(asdict(rows[0])))
            writer.writeheader()
            writer.writerows(asdict(row) for row in rows)


if __name__ == "__main__":
    main()
