"""Tone on the right that holds the right half of the built-in head while a unit acts on the left: docs/facs.md.

    python benchmarks/contralateral_tone.py [SIZE]

Gauss-Newton steps on the full model with contact of lips: at each equilibrium, activations of the right's muscles from
bounded least squares on du/dp, reweighted (Lawson 1961) towards the smallest largest motion of the visible skin more
than 10 mm right of the midline, each unit's in shares of its peak.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import lsq_linear

from risorius.jaw import FloatArray
from risorius_offline.contact_choice import ContactChoice
from risorius_offline.effect_choice import EffectChoice
from risorius_offline.equilibrium import Equilibrium, EquilibriumSolver
from risorius_offline.head import built_in_head
from risorius_offline.sensitivities import sensitivities

STRONGEST = 0.3  # activation that is still tone
BEYOND = (0, 10)  # mm from the midline, printed
ROUNDING = 1e-9  # metres, of the place of vertices on the midline, which are of neither half
HELD = 10  # mm from the midline, beyond which the skin is to stay still
STEPS = (1.0, 0.7, 0.7, 0.7)  # shares of the Gauss-Newton steps
REWEIGHTINGS = 8

BROW = ("frontalis_medialis", "frontalis_lateralis", "procerus", "depressor_supercilii", "corrugator_supercilii")
RING = (
    "orbicularis_oris_marginalis_superior",
    "orbicularis_oris_marginalis_inferior",
    "orbicularis_oris_peripheralis_superior",
    "orbicularis_oris_peripheralis_inferior",
    "incisivus_labii_superioris",
    "incisivus_labii_inferioris",
    "buccinator",
)
MOUTH = (
    *RING,
    "levator_anguli_oris",
    "depressor_anguli_oris",
    "zygomaticus_major",
    "risorius",
    "levator_labii_superioris",
    "depressor_labii_inferioris",
    "mentalis",
    "depressor_septi_nasi",
    "nasalis_transversa",
    "nasalis_alaris",
)
# Units that share one tone, and the muscles that may have it.
CASES = (
    *(((f"AU{number}",), BROW) for number in (1, 2, 4)),
    *(((f"AU{number}",), MOUTH) for number in (*range(8, 19), *range(20, 26), 28, 38, 39)),
    (("AU12", "AU14", "AU20"), RING),
)


@dataclass(frozen=True)
class RightHalf:
    """The full model, and the visible skin from the midline to the right."""

    solver: EquilibriumSolver

    def motion(self, u: FloatArray) -> FloatArray:
        """Motion (vertices, 3) of the visible skin, mm."""
        result: FloatArray = 1e3 * (self.solver.model.anatomy.surface.weights @ u)
        return result

    def beyond(self, distance: float) -> FloatArray:
        """Vertices farther right of the midline than a distance in mm."""
        return np.flatnonzero(self.solver.model.anatomy.surface.points[:, 0] < -1e-3 * distance - ROUNDING)

    def row(self, unit: str, tone: dict[str, float]) -> tuple[float, list[float]]:
        """Peak (mm) of a unit on the left with a tone on the right, and shares of it by distance on the right."""
        length = np.linalg.norm(self.motion(self.equilibrium(unit, tone).u), axis=1)
        peak = float(length.max())
        return peak, [float(length[self.beyond(distance)].max()) / peak for distance in BEYOND]

    def equilibrium(self, unit: str, tone: dict[str, float]) -> Equilibrium:
        """Equilibrium of a unit at full weight on the left with a tone on the right."""
        inputs = self.solver.model.anatomy.inputs
        muscles = {f"{name}_R": activation for name, activation in tone.items()}
        return self.solver.solve(inputs.to_parameters(inputs.weights({f"{unit}_L": 1.0}), muscles))

    def fitted_tone(self, units: Sequence[str], names: Sequence[str]) -> dict[str, float]:
        """Activation of the named muscles that keeps the right half stillest in all units, without those below 0.01."""
        anatomy = self.solver.model.anatomy
        columns = [anatomy.inputs.parameters.index(f"{name}_R") for name in names]
        tone = np.zeros(len(names))
        for share in STEPS:
            moved, by_tone = [], []
            for unit in units:
                state = self.equilibrium(unit, dict(zip(names, tone, strict=True)))
                change = sensitivities(self.solver.model, state)[columns]
                peak = np.linalg.norm(self.motion(state.u), axis=1).max()
                held = self.beyond(HELD)
                moved.append(self.motion(state.u)[held] / peak)
                by_tone.append(np.stack([self.motion(field)[held] for field in change], axis=2) / peak)
            step = least_largest(np.concatenate(by_tone), np.concatenate(moved), tone)
            tone = np.clip(tone + share * step, 0.0, STRONGEST)
        return {name: round(float(a), 2) for name, a in zip(names, tone, strict=True) if a >= 0.01}


def least_largest(by_tone: FloatArray, moved: FloatArray, tone: FloatArray) -> FloatArray:
    """Change (m,) of a tone in [0, STRONGEST] for the least largest motion: moved (k, 3), by_tone (k, 3, m)."""
    weights = np.ones(len(moved))
    step = np.zeros_like(tone)
    for _ in range(REWEIGHTINGS):
        root = np.sqrt(weights)[:, None]
        matrix = (by_tone * root[..., None]).reshape(-1, len(tone))
        step = lsq_linear(matrix, -(moved * root).ravel(), bounds=(-tone - 1e-9, STRONGEST - tone + 1e-9)).x
        left = np.linalg.norm(moved + by_tone @ step, axis=1) ** 4
        weights = 0.5 * weights + 0.5 * left / left.mean()
    return step


def main() -> None:
    """Print the table in Markdown."""
    anatomy = built_in_head(sys.argv[1] if len(sys.argv) > 1 else "draft")
    right = RightHalf(EquilibriumSolver(EffectChoice(ContactChoice.LIPS).model(anatomy)))
    distances = "".join(f" beyond {far} mm |" for far in BEYOND)
    print(f"| on the left alone | peak, mm, without and with |{distances} tone |")
    print("|---" * (3 + len(BEYOND)) + "|")
    for units, names in CASES:
        tone = right.fitted_tone(units, names)
        for unit in units:
            (peak, shares), (peak_held, held) = right.row(unit, {}), right.row(unit, tone)
            cells = "".join(f" {100 * a:.0f}, {100 * b:.0f} % |" for a, b in zip(shares, held, strict=True))
            used = ", ".join(f"{name.replace('_', ' ')} {a:g}" for name, a in tone.items())
            print(f"| {unit} | {peak:.1f}, {peak_held:.1f} |{cells} {used} |", flush=True)


if __name__ == "__main__":
    main()
