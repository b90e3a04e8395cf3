"""From a model and a scene to a smaller model that holds only what the scene calls for."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from risorius.coarsening import coarse_surface
from risorius.effects import EFFECTS, Effect, Surroundings
from risorius.effects.contact import Contact
from risorius.effects.contact_reach import ReachableContact
from risorius.effects.gravity import Gravity
from risorius.effects.leaning import LEANING
from risorius.errors import InputError
from risorius.evaluators import CorrectedMap, Setting, Superposition
from risorius.hyper_reduction.muscles import ReducedMuscles
from risorius.inputs import InputTable
from risorius.jaw import FloatArray
from risorius.model import ReducedModel
from risorius.operating_point import OperatingPoint
from risorius.part import Numbers, Part
from risorius.pipeline import ALONE, pipelines
from risorius.regions import region_vertices, triangles_within
from risorius.scene import Scene

# Metres that the modes which are left out may move any kept vertex if all of them did their most at once, one way: what
# they do is a tenth of that, which makes up for that their most is taken from a sample of inputs.
TOLERANCE = 1e-5
SAMPLES = 256
ACTIVE_SHARES = (0.1, 0.3, 1.0)  # of the inputs of a sample


@dataclass(frozen=True)
class Plan:
    """model: what is left of a model for a scene, with its points and effects, all of which the scene calls for.

    vertex_numbers (n,): of its vertices in the whole model. muscles: what their work is found from, where it is wanted.
    """

    model: ReducedModel
    vertex_numbers: Numbers
    muscles: ReducedMuscles | None = None


def planned(model: ReducedModel, scene: Scene) -> Plan:
    """Compile a scene. Vertices are those of the whole model within 0.01 mm, where its guard lets a frame pass.

    Raises InputError for what the model has not.
    """
    points, effects, muscles = _points(model, scene), _effects(model, scene), _muscles(model, scene)
    methods = {point.setting.method for point in points} | {Superposition.name}
    evaluators = {name: evaluator for name, evaluator in model.evaluators.items() if name in methods}
    model = replace(model, points=points, effects=effects, evaluators=evaluators)
    table = _inputs(model, scene)
    vertices, triangles = _surface(model, scene)
    if table == model.inputs and len(vertices) == len(model.rest_vertices):
        return Plan(model, vertices, muscles)
    part = _part(model, table, vertices)
    states = _states(model, table, part)
    if muscles is None:  # whose work takes all modes
        part = part.with_modes(_excited(model, part, np.abs(states[:, model.lifts :]).max(axis=0)))
    else:
        muscles = muscles.within(part.parameters[: len(table.muscles)], part.coordinates)
    reduced = _reduced(model, table, part, triangles, states)
    return Plan(reduced if table == model.inputs else _reachable(reduced), vertices, muscles)


def _reachable(model: ReducedModel) -> ReducedModel:
    """Return a model whose contact looks at what its inputs can bring to touch anything."""
    contact = model.effects.get(Contact.name)
    if not isinstance(contact, Contact):
        return model
    reachable = ReachableContact.of(contact, model.rest_vertices, _frames(model))
    return replace(model, effects={**model.effects, Contact.name: reachable})


def _frames(model: ReducedModel) -> Iterator[tuple[FloatArray, npt.NDArray[np.float32]]]:
    """Coordinates and vertices that samples of the inputs bring about without contact, however the head is held."""
    others = tuple(effect for name, effect in model.effects.items() if name != Contact.name)
    vertices = np.empty_like(model.rest_vertices)
    held = [ALONE, *(Surroundings(gravity=pose) for pose in LEANING)] if Gravity.name in model.effects else [ALONE]
    for way in pipelines(model, _most_modes(model), others):
        for number, parameters in enumerate(_samples(model.inputs)):
            way.solve(parameters, held[number % len(held)])
            way.write(vertices)
            yield way.coordinates, vertices


def _points(model: ReducedModel, scene: Scene) -> tuple[OperatingPoint, ...]:
    """Operating points that show what the scene asks for."""
    linear = tuple(point for point in model.points if point.setting.method == Superposition.name)
    found = model.points if scene.nonlinear else linear
    if not found or (scene.nonlinear and len(found) == len(linear)):
        wanted = "that lets muscles interact" if scene.nonlinear else f"of {Superposition.name!r}"
        raise InputError(f"model {model.name!r} has no operating point {wanted}, as the scene needs; train anew")
    return found


def _effects(model: ReducedModel, scene: Scene) -> Mapping[str, Effect]:
    """Return those that the scene calls for."""
    for name, kind in EFFECTS.items():
        if getattr(scene, name) and name not in model.effects:
            raise InputError(f"scene: {name}: model {model.name!r} is without; train it from {kind.needs}")
    wanted = [name for name in EFFECTS if name in model.effects and getattr(scene, name) is not False]
    return {name: model.effects[name] for name in wanted}


def _muscles(model: ReducedModel, scene: Scene) -> ReducedMuscles | None:
    """Return what the work of the muscles is found from, if it is wanted."""
    if "effort" not in scene.outputs:
        return None
    corrected = model.evaluators.get(CorrectedMap.name)
    if not isinstance(corrected, CorrectedMap):
        raise InputError(
            f"scene: outputs: effort: model {model.name!r} has no muscles as physics; "
            "train it from snapshots that hold the body of the face"
        )
    return corrected.muscles


def _inputs(model: ReducedModel, scene: Scene) -> InputTable:
    """Return the inputs of the scene, over those muscles and motions that they drive."""
    table = model.inputs
    if scene.jaw and model.poses.jaw is None:
        raise InputError(f"scene: jaw: model {model.name!r} has none; train it from a face with a mandible")
    if scene.jaw is False and model.poses.jaw is not None:
        table = InputTable(table.muscles, tuple(name for name in table.poses if name not in model.poses.jaw.inputs))
    if scene.inputs is None:
        return table
    names, muscles = set[str](), set[str]()
    for name in scene.inputs:
        if name in table.aliases:
            names |= {table.names[position] for position in table.aliases[name]}
        elif name in table.muscle_aliases:
            muscles |= {table.muscles[position] for position in table.muscle_aliases[name]}
        else:
            raise InputError(f"scene: inputs: {table.unknown(name)}; muscles: {', '.join(table.muscles)}")
    rows = [position for position, name in enumerate(table.names) if name in names]
    driven = {table.parameters[number] for number in np.flatnonzero(table.drive[rows].any(axis=0))} | muscles
    if not driven:
        raise InputError("scene: inputs: none given; leave the field out for all inputs of the model")
    motions = [motion.inputs for motion in model.poses.motions if driven & set(motion.inputs)]
    return InputTable(
        muscles=tuple(name for name in table.muscles if name in driven),
        poses=tuple(name for inputs in motions for name in inputs),
        only=frozenset(names | muscles),
    )


def _surface(model: ReducedModel, scene: Scene) -> tuple[Numbers, npt.NDArray[np.int32]]:
    """Numbers of the vertices (n,) of the scene, and triangles (t, 3) in the numbers of these."""
    vertices = region_vertices(model, scene.region)
    triangles = triangles_within(model.triangles, vertices)
    if scene.resolution == "full":
        return vertices, triangles
    if not len(triangles):
        raise InputError("scene: resolution: carriers need a surface, and the region has no triangle; leave it out")
    weights = model.carried_basis.weights[vertices]
    kept, triangles = coarse_surface(model.rest_vertices[vertices], triangles, weights)
    return vertices[kept], triangles


def _part(model: ReducedModel, table: InputTable, vertices: Numbers) -> Part:
    """Return what is left before modes are left out."""
    kept = [number for number, name in enumerate(model.inputs.parameters) if name in table.parameters]
    lifts, first = list[int](), 0
    for motion in model.poses.motions:
        lifts += range(first, first + motion.lift_count) if motion.inputs[0] in table.poses else ()
        first += motion.lift_count
    muscle = np.arange(len(kept)) < len(table.muscles)  # these can be driven by name, too
    return Part(
        parameters=np.array(kept, np.int64),
        driven=table.drive.any(axis=0) | muscle,
        lifts=np.array(lifts, np.int64),
        modes=np.arange(model.rank - model.lifts),
        carriers=np.unique(model.carried_basis.weights[vertices].indices).astype(np.int64),
        vertices=vertices,
        lift_count=model.lifts,
    )


def _states(model: ReducedModel, table: InputTable, part: Part) -> FloatArray:
    """Coordinates (s, r) that samples of the inputs bring about, with every evaluator of the points."""
    ways = pipelines(model, _most_modes(model), tuple(model.effects.values()))
    states = []
    for drawn in _samples(table):
        parameters = np.zeros(len(model.inputs.parameters))
        parameters[part.parameters] = drawn
        for way in ways:
            way.solve(parameters)
            states.append(way.coordinates[: model.rank].copy())
    return np.array(states)


def _most_modes(model: ReducedModel) -> Iterable[Setting]:
    """Settings, of each method one with most modes."""
    ordered = sorted(model.points, key=lambda one: one.setting.rank)
    return {point.setting.method: point.setting for point in ordered}.values()


def _samples(table: InputTable) -> FloatArray:
    """Parameters (s, p): every input and every muscle alone at its most, all together, and random ones."""
    rng, lowest = np.random.default_rng(0), table.lower
    random = np.array([
        np.where(rng.random(len(lowest)) < ACTIVE_SHARES[number % len(ACTIVE_SHARES)], rng.uniform(lowest, 1.0), 0.0)
        for number in range(SAMPLES)
    ])  # fmt: skip
    weights = np.vstack([np.eye(len(lowest)), np.diag(lowest), np.ones(len(lowest)), random])
    drawn = [table.to_parameters(row) for row in weights]
    return np.vstack([*drawn, np.eye(len(table.parameters))[: len(table.muscles)]])


def _excited(model: ReducedModel, part: Part, reach: FloatArray) -> Numbers:
    """Modes, never none, without those of all (r,) that together move no kept vertex by more than TOLERANCE.

    With effects no vertex at all: they feel how the whole face moves.
    """
    weights = abs(model.carried_basis.weights)
    sizes = np.linalg.norm(model.carried_basis.fields[model.lifts :], axis=2)
    moved = reach[:, None] * ((weights if model.effects else weights[part.vertices]) @ sizes.T).T
    order = np.argsort(moved.max(axis=1), kind="stable")
    together, kept = np.zeros(moved.shape[1]), np.ones(len(moved), bool)
    for mode in order[order > 0]:
        together += moved[mode]
        if together.max() > TOLERANCE:
            break
        kept[mode] = False
    return np.flatnonzero(kept)


def _reduced(
    model: ReducedModel, table: InputTable, part: Part, triangles: npt.NDArray[np.int32], states: FloatArray
) -> ReducedModel:
    """Return what a part is, with triangles of its own."""
    return replace(
        model,
        inputs=table,
        poses=model.poses.within(part.parameters[len(table.muscles) :] - len(model.inputs.muscles)),
        rest_vertices=np.ascontiguousarray(model.rest_vertices[part.vertices]),
        triangles=triangles,
        carried_basis=model.carried_basis.within(part),
        evaluators={name: evaluator.within(part) for name, evaluator in model.evaluators.items()},
        points=tuple(replace(point, setting=point.setting.within(part)) for point in model.points),
        colours=model.colours[part.vertices] if len(model.colours) else model.colours,
        effects={name: effect.within(part) for name, effect in model.effects.items()},
        watch=None if model.watch is None else model.watch.within(part.coordinates, states),
    )
