"""Hard solves of any anatomy, for the gauntlet of a reduced model: what they come to, judged by another full model."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import asdict, dataclass, replace

import numpy as np

from risorius.gauntlet.full_model import HardSolved
from risorius.jaw import FloatArray
from risorius.mechanics.material import Yeoh
from risorius_offline.anatomy import load_source
from risorius_offline.anatomy.anatomy import Anatomy
from risorius_offline.equilibrium import EquilibriumSolver, NotConvergedError
from risorius_offline.full_model import FullModel
from risorius_offline.jacobian_bounds import jacobian_bounds

RATIO = 1000.0
POISSON = (0.499, 0.4999)


@dataclass(frozen=True)
class Judged:
    """Found on a model that has not solved anything: smallest_jacobian bounds J everywhere from below."""

    finite: bool
    smallest_jacobian: float
    residual: float


@dataclass(frozen=True)
class HardSolve:
    """An anatomy to solve at parameters (p,), from an equilibrium at `start` (p,) or from rest."""

    name: str
    anatomy: Anatomy
    parameters: FloatArray
    start: FloatArray | None = None


def judge(model: FullModel, parameters: FloatArray, u: FloatArray) -> Judged:
    """Judge a displacement (n, 3) at parameters (p,), whatever the report of its solver says."""
    model.set_parameters(parameters)
    forces = model.forces(u)[2]
    residual = float(np.linalg.norm(forces.reshape(-1)[model.free])) / model.force_scale(forces)
    everywhere = jacobian_bounds(model.discretisation, u).lower
    smallest = min(float(everywhere.min()), float(model.point_jacobians(u).min()))
    return Judged(bool(np.isfinite(u).all()), smallest, residual)


def hard_solves(source: str) -> Iterator[HardSolved]:
    """What the cases of an anatomy come to, one after another; raises InputError for a source that is none."""
    return map(attempt, cases(load_source(source)))


def attempt(case: HardSolve) -> HardSolved:
    """Solve a case; a refusal is a result, every other error passes."""
    solver = EquilibriumSolver(FullModel(case.anatomy))
    try:
        start = None if case.start is None else solver.solve(case.start)
        u = solver.solve(case.parameters, start).u
    except NotConvergedError as error:
        return HardSolved(case.name, refused=str(error))
    judged = judge(FullModel(case.anatomy), case.parameters, u)
    return HardSolved(case.name, farthest=float(np.linalg.norm(u, axis=1).max()), **asdict(judged))


def cases(anatomy: Anatomy) -> list[HardSolve]:
    """What is asked of every anatomy; layers of different stiffness only where it has layers."""
    inputs = anatomy.inputs
    muscles = (np.arange(len(inputs.parameters)) < len(inputs.muscles)).astype(np.float64)
    every, lowest = np.ones(len(muscles)), inputs.parameter_lower
    found = [
        HardSolve("every muscle at 1", anatomy, muscles),
        HardSolve("every muscle at 1.3", anatomy, 1.3 * muscles),
        HardSolve("every muscle at 5e-324", anatomy, 5e-324 * muscles),
        HardSolve("from every muscle at 1 back to rest", anatomy, 0.0 * muscles, start=muscles),
    ]
    if anatomy.poses.inputs:
        found += [
            HardSolve("every pose at 1", anatomy, 1.0 - muscles),
            HardSolve("every pose at its lowest", anatomy, lowest),
            HardSolve("every muscle and pose at 1", anatomy, every),
        ]
    for poisson in POISSON:
        stiff = tuple(_with_poisson(material, poisson) for material in anatomy.materials)
        found.append(HardSolve(f"Poisson's ratio {poisson}", replace(anatomy, materials=stiff), muscles))
    if len(anatomy.materials) > 1:
        for parity, name in ((0, "even"), (1, "odd")):
            layered = tuple(
                _scaled(material, RATIO if number % 2 == parity else 1.0)
                for number, material in enumerate(anatomy.materials)
            )
            found.append(HardSolve(f"{name} layers 1000 times stiffer", replace(anatomy, materials=layered), muscles))
    return found


def _with_poisson(material: Yeoh, poisson: float) -> Yeoh:
    """Return the material with the bulk modulus that its shear modulus has at a Poisson's ratio."""
    shear = 2.0 * material.c10
    return replace(material, bulk=2.0 * shear * (1.0 + poisson) / (3.0 * (1.0 - 2.0 * poisson)))


def _scaled(material: Yeoh, factor: float) -> Yeoh:
    return Yeoh(factor * material.c10, factor * material.c20, factor * material.bulk)
