"""Which parameter vectors to solve: a seeded sequence for training, and another that is held out.

A sample depends on the seed and on its own number only, so a longer run contains a shorter one. A new part of the
design is one function in `combinations`, and its place in a cycle here.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from functools import partial
from itertools import chain, cycle, islice

import numpy as np

from risorius.expressions import possible_expressions
from risorius.inputs import InputTable
from risorius.jaw import FloatArray
from risorius.snapshot_store import Samples
from risorius_offline.sampling.actions import Actions
from risorius_offline.sampling.combinations import KINDS, points

DESIGN = 1  # number of this design: samples of another do not mix with it
PATH_LENGTH = 4
TRAINING_STREAM, HELD_OUT_STREAM = 0, 1
TRAINING_CYCLE = (
    *("ordinary", "strong", "ramp", "ordinary", "asymmetric", "ordinary", "opposing", "ordinary"),
    *("posed", "ordinary", "ramp", "ordinary", "strong", "ordinary", "asymmetric", "ordinary"),
)
HELD_OUT_CYCLE = ("ordinary", "ordinary", "strong", "ordinary")
RAMP = (0.25, 0.5, 0.75)  # the end of a ramp is a sample of its own


def design(inputs: InputTable, count: int, held_out: int, seed: int) -> Samples:
    """Training samples up to `count`, and `held_out` more that training never reads.

    All parameters alone at weight 1 are included, however small `count` is. Then come both sides of each action, the
    named expressions and all muscles together, and after them combinations, without end.
    """
    count = max(count, len(inputs.parameters))
    training = list(islice(training_sequence(inputs, seed, count), count))
    testing = list(islice(_combinations(inputs, HELD_OUT_CYCLE, (seed, HELD_OUT_STREAM), held_out), held_out))
    return Samples(
        parameters=np.array([parameters for _, parameters in training + testing]),
        kinds=[kind for kind, _ in training + testing],
        held_out=np.arange(count + held_out) >= count,
        # A path is one of training or of held-out samples: neither shifts when there is more of the other.
        paths=np.array([2 * (k // PATH_LENGTH) for k in range(count)]
                       + [2 * (k // PATH_LENGTH) + 1 for k in range(held_out)]),
    )  # fmt: skip


def training_sequence(inputs: InputTable, seed: int, longest: int) -> Iterator[tuple[str, FloatArray]]:
    """Kind and parameters (p,) of the training samples, in order; `longest`: how many may be asked for."""
    seen: set[bytes] = set()
    endless = _combinations(inputs, TRAINING_CYCLE, (seed, TRAINING_STREAM), longest)
    for kind, parameters in chain(_fixed(inputs), endless):
        key = (parameters + 0.0).tobytes()
        if key not in seen:
            seen.add(key)
            yield kind, parameters


def _fixed(inputs: InputTable) -> Iterator[tuple[str, FloatArray]]:
    """Each parameter at 1 and at its least below 0; the same of both sides; named expressions; all muscles."""
    identity, actions = np.eye(len(inputs.parameters)), Actions.of(inputs)
    yield from (("single", row) for row in identity)
    lower = inputs.parameter_lower
    yield from (("single", least * row) for least, row in zip(lower, identity, strict=True) if least < 0.0)
    yield from (("single", action.at(1.0, actions.count)) for action in (*actions.muscles, *actions.poses))
    yield from (("single", action.at(action.lower, actions.count)) for action in actions.poses if action.lower < 0.0)
    yield from (("expression", parameters) for parameters in _expressions(inputs))
    if inputs.muscles:
        yield "strong", identity[: len(inputs.muscles)].sum(axis=0)


def _expressions(inputs: InputTable) -> list[FloatArray]:
    return [inputs.to_parameters(inputs.weights(found.weights)) for found in possible_expressions(inputs.names)]


def _combinations(
    inputs: InputTable, kinds: Sequence[str], key: tuple[int, int], count: int
) -> Iterator[tuple[str, FloatArray]]:
    """Samples of the kinds in turn, `count` at least, each from a sequence of points of its own."""
    actions, wanted = Actions.of(inputs), Counter(islice(cycle(kinds), count + len(kinds)))
    wanted["ordinary"] += wanted["ramp"]
    streams: dict[str, Iterator[FloatArray]] = {
        kind: map(partial(make, actions), points(actions, wanted[kind], (*key, number)))
        for number, (kind, make) in enumerate(KINDS.items())
    }
    streams["ramp"] = _ramps(inputs, actions, key)
    for kind in islice(cycle(kinds), count + len(kinds)):
        parameters = next(streams[kind], None)
        if parameters is None:  # the ramps have come to an end
            yield "ordinary", next(streams["ordinary"])
        else:
            yield kind, parameters


def _ramps(inputs: InputTable, actions: Actions, key: tuple[int, int]) -> Iterator[FloatArray]:
    """Actions and expressions at growing weights, in an order that the seed gives."""
    ends = [action.at(1.0, actions.count) for action in (*actions.muscles, *actions.poses)] + _expressions(inputs)
    order = np.random.default_rng((*key, len(KINDS))).permutation(len(ends))
    yield from (level * ends[number] for number in order for level in RAMP)
