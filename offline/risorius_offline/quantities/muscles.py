"""Force and work of the muscles at an equilibrium."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from risorius.jaw import FloatArray
from risorius_offline.active_fibres import ActiveFibres
from risorius_offline.discretisation import Discretisation
from risorius_offline.equilibrium import Equilibrium
from risorius_offline.full_model import FullModel
from risorius_offline.muscles.assembly import dead_loads, fibre_points, force_density
from risorius_offline.muscles.loads import ActiveStress, ForceDensity
from risorius_offline.muscles.muscle import Muscle


@dataclass(frozen=True)
class MuscleState:
    """Of every muscle (m,), in the order of the anatomy: activation a, stretch, force and work.

    stretches: lambda = |F a0|, the mean over the volume of the muscle at rest.
    forces: newtons. Of an active stress (7.2) the integral of a T f over that volume, f the model's fibre law, over
    the length of the fibres at rest: a T f A in a straight bar of cross-section A at rest. Of a force density (7.3) the
    integral of a |lambda tau|: what the origin of a straight bar holds.
    works: joules given off from rest to this state with the activation held, positive where the muscle shortens. Of an
    active stress the integral of a T (W(1) - W(lambda)), W' = f; of a force density the integral of a lambda tau . u.
    """

    activations: FloatArray
    stretches: FloatArray
    forces: FloatArray
    works: FloatArray


def muscle_state(model: FullModel, equilibrium: Equilibrium) -> MuscleState:
    """Muscles of a model at an equilibrium, or at any other displacement and activation."""
    discretisation, muscles = model.discretisation, model.anatomy.muscles
    activations, u = equilibrium.parameters[: model.muscle_count], equilibrium.u
    lengths = np.array([muscle.fibres.length(discretisation) for muscle in muscles])
    # A force density has no active stress, but fibres whose stretch is measured all the same.
    measured = [m if isinstance(m.load, ActiveStress) else replace(m, load=ActiveStress(0.0)) for m in muscles]
    points = fibre_points(discretisation, measured)
    fibres = ActiveFibres(discretisation, points, len(muscles), model.fibres.law)
    volumes, stretched, tensions, released = fibres.integrals(u, activations).T
    return MuscleState(
        activations=activations,
        stretches=stretched / volumes,
        forces=tensions / lengths + activations * _dead_forces(discretisation, muscles),
        works=released + activations * (u.ravel() @ dead_loads(discretisation, muscles)),
    )


def _dead_forces(discretisation: Discretisation, muscles: Sequence[Muscle]) -> FloatArray:
    """(m,) integral of |lambda tau| at full activation, newtons; zero for an active stress."""
    volumes = np.concatenate([block.weights.ravel() for block in discretisation.volumes])
    forces = np.zeros(len(muscles))
    for number, muscle in enumerate(muscles):
        if isinstance(muscle.load, ForceDensity):
            forces[number] = volumes @ np.linalg.norm(force_density(discretisation, muscle, muscle.load), axis=1)
    return forces
