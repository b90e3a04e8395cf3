"""What the best coordinates in several bases leave of held-out snapshots: benchmarks/bases.py SNAPSHOTS SOURCE.

Errors of the visible vertices in mm, mean / 95 % / max, without any map: what no map in that basis can be better than.
Bases that need no random snapshots: vibration modes of the tissue at rest, alone and with modal derivatives (Barbic and
James 2005); static modes of the muscles; single actions with their derivatives. Of snapshots and their mirror images:
the product's POD, and POD of windows of the face (modes of bounded support).
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from itertools import combinations_with_replacement
from pathlib import Path

import numpy as np
from scipy.cluster.vq import kmeans2
from scipy.sparse.linalg import LinearOperator, eigsh

from risorius.bases import pod
from risorius.modal import visible_measure
from risorius.snapshot_file import SnapshotSet
from risorius.symmetry import mirror_of
from risorius.training import project
from risorius_offline.anatomy import load_source
from risorius_offline.full_model import FullModel
from risorius_offline.inertia import Inertia, Medium

COUNTS = (60, 120, 240)
WINDOWS = (8, 24)
STEP = 2e-3  # metres, of the differences of forces that make modal derivatives


class Faces:
    """Displacements (s, n, 3) less what the poses prescribe, and the measure (n,) in which they are projected."""

    def __init__(self, snapshots: SnapshotSet) -> None:
        self.snapshots, self.measure = snapshots, visible_measure(snapshots)
        self.root = np.sqrt(np.repeat(self.measure, 3))
        self.singles = np.asarray(snapshots.single_actions())
        mirror = mirror_of(snapshots, self.singles)
        own = self.fluctuations(np.flatnonzero(~snapshots.held_out))
        self.seen = own if mirror is None else np.concatenate([own, mirror.image(own)])

    def fluctuations(self, rows: np.ndarray) -> np.ndarray:
        poses = self.snapshots.parameters[rows, len(self.snapshots.muscles) :]
        lifts = np.stack([self.snapshots.poses.lift_coordinates(weights) for weights in poses])
        prescribed = np.tensordot(lifts, self.snapshots.lift_fields, axes=1)
        return self.snapshots.displacements[rows].astype(np.float64) - prescribed

    def pod(self, fields: np.ndarray, count: int) -> np.ndarray:
        return pod(lambda: [fields], self.measure, min(count, len(fields)))[0]

    def slopes_of_singles(self) -> np.ndarray:
        """Derivatives (k, n, 3) of the single actions by all parameters, less those of what the poses prescribe."""
        found, muscles = [], len(self.snapshots.muscles)
        for row in self.singles:
            slopes = self.snapshots.poses.lift_slopes(self.snapshots.parameters[row, muscles:])
            own = self.snapshots.derivatives[row].astype(np.float64)
            own[muscles:] -= np.tensordot(slopes, self.snapshots.lift_fields, axes=1)
            found.append(own)
        return np.concatenate(found)

    def tell(self, name: str, fields: np.ndarray) -> None:
        """Print what the best sum of fields (k, n, 3) leaves of the held-out snapshots of each kind."""
        flat = fields.reshape(len(fields), -1) * self.root
        left, sizes, _ = np.linalg.svd(flat.T, full_matrices=False)
        left = left[:, sizes > 1e-9 * sizes[0]]
        kinds, texts = np.array(self.snapshots.kinds), []
        for kind in ("ordinary", "strong"):
            truth = self.fluctuations(np.flatnonzero(self.snapshots.held_out & (kinds == kind)))
            rest = truth.reshape(len(truth), -1) * self.root
            rest = (rest - rest @ left @ left.T) / self.root
            errors = 1e3 * np.linalg.norm(self.snapshots.surface.carry(rest.reshape(truth.shape)), axis=2)
            texts.append(f"{errors.mean():.3f} / {np.quantile(errors, 0.95):.2f} / {errors.max():.1f}")
        print(f"{name}, {left.shape[1]} modes | {' | '.join(texts)}", flush=True)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("snapshots", type=Path)
    parser.add_argument("source")
    options = parser.parse_args()
    faces, full = Faces(SnapshotSet.load(options.snapshots)), FullModel(load_source(options.source))
    for windows in WINDOWS:
        for count in COUNTS:
            faces.tell(f"POD of {windows} windows", windowed(faces, windows, count // windows))
    full.factorise(*full.tangent(np.zeros_like(full.anatomy.points)))
    faces.tell("static", static(full))
    vibrations = vibration(full, max(COUNTS))
    for count in COUNTS:
        faces.tell("vibration", vibrations[:count])
    for count in COUNTS:
        faces.tell("vibration and modal derivatives", np.concatenate(list(with_derivatives(full, vibrations, count))))
    singles, slopes = faces.fluctuations(faces.singles), faces.slopes_of_singles()
    faces.tell("single actions", singles)
    for count in COUNTS[1:]:
        faces.tell("single actions and derivatives", np.concatenate([singles, faces.pod(slopes, count - len(singles))]))
    modes = project(faces.snapshots, max(COUNTS)).modes
    for count in COUNTS:
        faces.tell("POD", modes[:count])


def windowed(faces: Faces, windows: int, each: int) -> np.ndarray:
    """POD modes of the snapshots within each of some windows, which add up to one and end where the next but one is."""
    points = faces.snapshots.points
    centres = kmeans2(points, windows, seed=0, minit="++")[0]
    distances = np.linalg.norm(points[:, None] - centres, axis=2)
    weights = np.maximum(1.0 - distances / np.sort(distances, axis=1)[:, [2]], 0.0)
    weights /= weights.sum(axis=1, keepdims=True)
    return np.concatenate([faces.pod(faces.seen * weights[:, [w]], each) for w in range(windows)])


def static(full: FullModel) -> np.ndarray:
    """First-order displacement (muscles, n, 3) of each muscle at rest, with the factors there."""
    forces = full.muscle_forces(np.zeros_like(full.anatomy.points))[full.free]
    return fields_of(full, full.solve(np.ascontiguousarray(-forces)).T)


def vibration(full: FullModel, count: int) -> np.ndarray:
    """Modes (count, n, 3) of least frequency of the tissue at rest, of which the factors are, none over a metre."""
    mass = Inertia(full.discretisation, Medium()).mass[full.free][:, full.free]
    inverse = LinearOperator(mass.shape, matvec=full.solve, dtype=np.float64)
    _, vectors = eigsh(inverse, count, M=mass, sigma=0.0, OPinv=inverse)
    fields = fields_of(full, vectors.T)
    return fields / np.abs(fields).max(axis=(1, 2), keepdims=True)


def with_derivatives(full: FullModel, modes: np.ndarray, count: int) -> Iterator[np.ndarray]:
    """The leading modes, as many as leave room for the derivatives of all pairs of them among `count` fields."""
    leading = next(k for k in range(len(modes), 0, -1) if k + k * (k + 1) // 2 <= count)
    yield modes[:leading]
    steps = [STEP * mode for mode in modes[:leading]]
    alone = [full.forces(step)[2] + full.forces(-step)[2] for step in steps]
    pairs = combinations_with_replacement(range(leading), 2)
    second = [
        full.forces(steps[a] + steps[b])[2] + full.forces(-steps[a] - steps[b])[2] - alone[a] - alone[b]
        for a, b in pairs
    ]
    right = np.stack([forces.reshape(-1)[full.free] for forces in second], axis=1)
    fields = fields_of(full, full.solve(-right).T)
    yield fields / np.maximum(np.abs(fields).max(axis=(1, 2), keepdims=True), np.finfo(float).tiny)


def fields_of(full: FullModel, free: np.ndarray) -> np.ndarray:
    """Displacements (k, n, 3) of free components (k, f)."""
    fields = np.zeros((len(free), *full.anatomy.points.shape))
    fields.reshape(len(free), -1)[:, full.free] = free
    return fields


if __name__ == "__main__":
    main()
