"""How much of the skin's basis could be left unread: the ideas of docs/skin_reconstruction.md that lost.

    python benchmarks/skin_compression.py SNAPSHOTS [--tolerance METRES ...]

Shares of the fields at the vertices (1 is all of them) that blocks of 64 neighbouring vertices need so that no vertex
of no snapshot is off by more than the tolerance. The modes of a block are left out from the least on; the rest is
judged by the root of the sum of its squares, which favours the ideas: the true error is larger.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from peers import one_thread  # noqa: F401  before all that starts threads

# isort: split

import numpy as np
from scipy.spatial import cKDTree
from skin_data import Modes

from risorius.jaw import FloatArray

MODES, BLOCK, ITERATIONS = 120, 64, 60


@dataclass(frozen=True)
class Fields:
    """values (r, v, 3) and coordinates (s, r)."""

    values: FloatArray
    coordinates: FloatArray

    def blocks(self) -> Iterator[FloatArray]:
        """Fields (r, BLOCK, 3) of one block after another."""
        for start in range(0, self.values.shape[1], BLOCK):
            yield self.values[:, start : start + BLOCK]

    def rotated(self, lifts: int) -> Fields:
        """Turn the modes, without the lifts, to where each moves as few vertices as can be."""
        turn = varimax(self.values[lifts:])
        values, coordinates = self.values.copy(), self.coordinates.copy()
        values[lifts:] = np.tensordot(turn.T, self.values[lifts:], axes=1)
        coordinates[:, lifts:] = self.coordinates[:, lifts:] @ turn
        return Fields(values, coordinates)


def varimax(fields: FloatArray) -> FloatArray:
    """Rotation (r, r) to sparse magnitudes of the vertices: varimax (Kaiser 1958) on groups of three components."""
    count = len(fields)
    flat, turn = fields.reshape(count, -1), np.eye(count)
    for _ in range(ITERATIONS):
        turned = turn.T @ flat
        squares = (turned.reshape(fields.shape) ** 2).sum(axis=2)
        pull = turned * np.repeat(squares, 3, axis=1) - turned * squares.mean(axis=1)[:, None]
        left, _, right = np.linalg.svd(flat @ pull.T)
        turn = left @ right
    return turn


def localised(fields: Fields, tolerance: float) -> float:
    """Share when a block keeps the modes that any snapshot needs."""
    largest = np.abs(fields.coordinates).max(axis=0)
    kept = [_needed(_reach(block)[None] * largest, tolerance) for block in fields.blocks()]
    return float(np.mean(kept)) / len(largest)


def moving(fields: Fields, tolerance: float) -> float:
    """Share that a snapshot needs of a block, on average."""
    sizes = np.abs(fields.coordinates)
    kept = [_needed(_reach(block) * sizes, tolerance).mean() for block in fields.blocks()]
    return float(np.mean(kept)) / sizes.shape[1]


def moving_since(fields: Fields, tolerance: float) -> float:
    """Share that a frame needs of a block when it adds a change of 2 % to the frame before."""
    return moving(Fields(fields.values, 0.02 * fields.coordinates), tolerance)


def local_bases(fields: Fields, tolerance: float) -> float:
    """Share when every block has POD modes of its own and a matrix that gives their coordinates."""
    read = 0
    for block in fields.blocks():
        moved = fields.coordinates @ block.reshape(len(block), -1)
        left, singular, right = np.linalg.svd(moved, full_matrices=False)
        rank = next(
            k
            for k in range(len(singular) + 1)
            if _largest((left[:, k:] * singular[k:]) @ right[k:]) < tolerance
        )  # fmt: skip
        read += rank * (moved.shape[1] + len(block))
    return read / fields.values.size


def _largest(moved: FloatArray) -> float:
    return float(np.linalg.norm(moved.reshape(len(moved), -1, 3), axis=2).max(initial=0.0))


def _reach(block: FloatArray) -> FloatArray:
    return np.linalg.norm(block, axis=2).max(axis=1)


def _needed(contributions: FloatArray, tolerance: float) -> FloatArray:
    """Number of contributions (s, r) to keep in each row."""
    left_out = np.sqrt(np.cumsum(np.sort(contributions, axis=1) ** 2, axis=1)) < tolerance
    return contributions.shape[1] - left_out.sum(axis=1)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("snapshots", type=Path)
    parser.add_argument("--tolerance", type=float, action="append", default=[])
    arguments = parser.parse_args()
    modes = Modes.of_snapshots(arguments.snapshots, MODES)
    order = cKDTree(modes.rest, leafsize=BLOCK).indices
    values = modes.surface.carry(modes.fields)[:, order]
    plain = Fields(values, modes.coordinates)
    turned = plain.rotated(len(modes.fields) - MODES)
    carried = modes.basis(len(modes.fields)).fields.size / values.size
    print(f"{values.shape[1]} vertices, {len(values)} coordinates; fields of the carrying points: {carried:.3f}")
    for tolerance in arguments.tolerance or [1e-6, 1e-5]:
        print(f"{1e6 * tolerance:g} um")
        for name, fields in (("POD modes", plain), ("modes turned to be local", turned)):
            shares = localised(fields, tolerance), moving(fields, tolerance), moving_since(fields, tolerance)
            print(f"  {name}: kept {shares[0]:.3f}, of a frame {shares[1]:.3f}, of a 2 % change {shares[2]:.3f}")
        print(f"  POD modes of each block: {local_bases(plain, tolerance):.3f}")


if __name__ == "__main__":
    main()
