"""What must hold of every frame, looked at from outside of the engine."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field

import numpy as np

from risorius.engine import Frame
from risorius.errors import Error, InputError
from risorius.evaluators import CorrectedMap
from risorius.gauntlet.case import Ask, Bench
from risorius.jaw import FloatArray

VERDICTS = {
    "answers": "every input is answered, or refused by an InputError where it has to be",
    "counted": "what is wrong with a message is counted",
    "finite": "all vertices, coordinates and errors are numbers",
    "bounded": "no vertex moves further than half of what the face measures",
    "honest": "a frame that was held says so",
    "unfolded": "no converged frame has J <= 0 at a watched point",
    "residual": "no converged frame that physics corrected has a longer residual than the map's answer",
    "energy": "what nothing pushes any more never gains energy of motion",
    "penetration": "with contact, no skin is more than 0.3 mm deeper in teeth or in the other lip than at rest",
    "needed": "no mouth goes back where nothing would be deeper than 0.2 mm in teeth or in the other lip without",
    "recovers": "the frame after the case is the face at rest",
}
FARTHEST = 0.5  # of the longest side of the face
SAME = 1e-6  # metres
ROUNDING = 1e-12  # joules
DEEPEST = 0.3e-3  # metres
FAILURES = (Error, ArithmeticError, ValueError, TypeError, LookupError)


@dataclass
class Judge:
    """Asks the engine of a bench and counts what does not hold, by verdict.

    smallest_jacobian: of converged frames; None without watched points. farthest: metres that a vertex has moved at
    most; deepest: metres that skin is in teeth or in the other lip. energy: joules of motion in the last frame.
    """

    bench: Bench
    broken: Counter[str] = field(default_factory=Counter)
    frames: int = 0
    refused: int = 0
    mended: int = 0
    held: int = 0
    went_back: int = 0
    smallest_jacobian: float | None = None
    farthest: float = 0.0
    deepest: float = 0.0
    energy: float = 0.0

    def take(self, ask: Ask) -> None:
        """Ask the engine, and judge what it answers."""
        self.broken["counted"] += not ask.counted
        try:
            frame = self.bench.evaluate(ask)
        except InputError:
            self.refused += 1
            self.broken["answers"] += not (ask.refused or ask.may_refuse)
            return
        except FAILURES:
            self.broken["answers"] += 1
            return
        self.broken["answers"] += ask.refused
        self._judge(frame, ask)

    def finish(self) -> None:
        """Judge whether a frame of rest is as if nothing had been."""
        frame = self.bench.evaluate(Ask(np.zeros_like(self.bench.lower)))
        off = np.abs(frame.vertices - self.bench.rest.vertices).max()
        self.broken["recovers"] += not (off <= SAME and frame.converged)

    def _judge(self, frame: Frame, ask: Ask) -> None:
        self.frames += 1
        self.held += not frame.converged
        self.mended += "mended" in frame.method
        self.went_back += "went back" in frame.method
        numbers = np.isfinite(frame.vertices).all() and np.isfinite(frame.coordinates).all()
        self.broken["finite"] += not (numbers and not np.isnan(frame.error))
        moved = np.linalg.norm(frame.vertices - self.bench.model.rest_vertices, axis=1).max()
        self.farthest = max(self.farthest, float(moved))
        self.broken["bounded"] += not moved <= FARTHEST * float(np.ptp(self.bench.model.rest_vertices, axis=0).max())
        self.broken["honest"] += frame.converged == (frame.method == "held")
        before, self.energy = self.energy, self.bench.engine.energy
        self.broken["energy"] += ask.free and not self.energy <= before + ROUNDING
        if frame.converged and numbers:
            self._judge_physics(frame, ask)

    def _judge_physics(self, frame: Frame, ask: Ask) -> None:
        model = self.bench.model
        state = frame.coordinates[: model.rank]
        if model.watch is not None:
            smallest = float(model.watch.jacobians(state).min())
            self.smallest_jacobian = min(smallest, np.inf if self.smallest_jacobian is None else self.smallest_jacobian)
            self.broken["unfolded"] += not smallest > 0.0
        if self.bench.penetration is not None:
            found = self.bench.penetration(frame.vertices, state)
            self.deepest = max(self.deepest, found.teeth, found.lips)
            self.broken["penetration"] += max(found.teeth, found.lips) > DEEPEST
        if self.bench.going_back is not None and "went back" in frame.method and not ask.touches:
            self.broken["needed"] += not self.bench.going_back.needed(frame.coordinates)
        corrected = self.bench.evaluator
        if isinstance(corrected, CorrectedMap) and frame.method == CorrectedMap.name and not self.bench.engine.effects:
            self.broken["residual"] += self._worsened(corrected, ask, state)

    def _worsened(self, corrected: CorrectedMap, ask: Ask, state: FloatArray) -> bool:
        parameters = self.bench.parameters(ask)
        answered = corrected.residual(parameters, state)
        corrected.coordinates(parameters, np.empty(self.bench.engine.point.setting.rank))
        return not answered <= max(corrected.doubt, corrected.quiet) * 1.001
