"""Force and work of the muscles at an equilibrium."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from risorius.jaw import FloatArray
from risorius_offline.anatomy.anatomy import Muscle
from risorius_offline.equilibrium import Equilibrium
from risorius_offline.full_model import FullModel


@dataclass(frozen=True)
class MuscleState:
    """Of every muscle (m,), in the order of the anatomy: activation a, stretch, force and work.

    stretches: lambda = |F a0|, the mean over the volume of the muscle.
    forces: newtons; the integral of a T lambda over that volume, divided by the length of the fibres at rest. It is
    minus the derivative of the work by the length of the fibres: a T A in a straight bar of cross-section A at rest.
    works: joules; the integral of a T (1 - lambda^2) / 2, the energy that the active stress of (7.2) gives off between
    rest and this state with the activation held; positive where the muscle shortens.
    """

    activations: FloatArray
    stretches: FloatArray
    forces: FloatArray
    works: FloatArray


def muscle_state(model: FullModel, equilibrium: Equilibrium) -> MuscleState:
    """Muscles of a model at an equilibrium, or at any other displacement and activation."""
    activations = equilibrium.parameters[: model.muscle_count]
    lengths = np.array([fibre_length(muscle) for muscle in model.anatomy.muscles])
    stretches, forces, works = np.zeros((3, model.muscle_count))
    for number, (stress, squares, volumes) in enumerate(_fibres(model, equilibrium.u)):
        stretch, pull = np.sqrt(squares), stress * volumes
        stretches[number] = volumes @ stretch / volumes.sum()
        forces[number] = pull @ stretch
        works[number] = 0.5 * pull @ (1.0 - squares)
    return MuscleState(activations, stretches, activations * forces / lengths, activations * works)


def fibre_length(muscle: Muscle) -> float:
    """Mean length at rest, metres, of the lines that a muscle is given by."""
    return float(np.mean([np.linalg.norm(np.diff(line, axis=0), axis=1).sum() for line in muscle.polylines]))


def _fibres(model: FullModel, u: FloatArray) -> Iterator[tuple[FloatArray, FloatArray, FloatArray]]:
    """T (k,) at full activation, lambda^2 (k,) and volume (k,) at the points of each muscle in turn."""
    blocks = model.discretisation.volumes
    volumes = np.concatenate([block.weights.ravel() for block in blocks])
    F = np.concatenate([block.deformation_gradients(u).reshape(-1, 3, 3) for block in blocks])
    C = np.einsum("pki,pkj->pij", F, F)
    for number in range(model.muscle_count):
        tensor = model.tissue.active_tensors[:, number].toarray().reshape(-1, 6)
        stress = tensor[:, :3].sum(axis=1)  # the trace of T a0 (x) a0
        inside = np.flatnonzero(stress)
        full = tensor[inside][:, [[0, 3, 5], [3, 1, 4], [5, 4, 2]]]
        yield stress[inside], np.einsum("pij,pij->p", C[inside], full) / stress[inside], volumes[inside]
