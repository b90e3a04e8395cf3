"""Facial action units: number, name and what drives them, after Table 7.2 of the seed (FACS, Ekman and Friesen).

Muscles carry the names of current anatomy in snake case; the seed's older names stand beside them: *triangularis*
is depressor anguli oris, *caninus* is levator anguli oris, *depressor labii* is depressor labii inferioris,
*depressor glabellae* is procerus. The masticatory muscles act as the pose of the jaw, levator palpebrae superioris and
its relaxation as the pose of the upper lid. What was chosen where the table is silent, and why: docs/facs.md.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType


@dataclass(frozen=True)
class ActionUnit:
    """One action unit.

    muscles: activation of each muscle at weight 1, both sides, by its name without `_L` or `_R`.
    poses: weight of each pose input at weight 1; of the lids both sides, without `_L` or `_R`.
    substitutes: muscles taken instead when a model has none of `muscles` and `poses`.
    helpers: muscles that act along with either of them, as far as a model has them.
    """

    number: int
    name: str
    muscles: Mapping[str, float] = field(default_factory=dict)
    poses: Mapping[str, float] = field(default_factory=dict)
    substitutes: Mapping[str, float] = field(default_factory=dict)
    helpers: Mapping[str, float] = field(default_factory=dict)


_MARGINAL, _PERIPHERAL = "orbicularis_oris_marginalis", "orbicularis_oris_peripheralis"
_ORBITAL, _PALPEBRAL = "orbicularis_oculi_orbitalis", "orbicularis_oculi_palpebralis"
_LID = "upper_lid"
_LEVATOR = "levator_palpebrae_superioris"


def _lips(number: int, name: str, marginal: float = 0.0, peripheral: float = 0.0, held: float = 0.0) -> ActionUnit:
    """Return a unit of orbicularis oris, whose parts are divided into upper and lower or, as substitutes, are not.

    held: share of buccinator, against which lips tighten: without it they shorten, and swell.
    """
    shares = {part: share for part, share in ((_MARGINAL, marginal), (_PERIPHERAL, peripheral)) if share}
    helpers = {"buccinator": held} if held else {}
    return ActionUnit(number, name, _upper_and_lower(shares), substitutes=shares, helpers=helpers)


def _upper_and_lower(shares: Mapping[str, float]) -> dict[str, float]:
    return {f"{part}_{lip}": share for part, share in shares.items() for lip in ("superior", "inferior")}


_ROWS = (
    ActionUnit(1, "Inner Brow Raiser", {"frontalis_medialis": 1.0}),
    ActionUnit(2, "Outer Brow Raiser", {"frontalis_lateralis": 1.0}),
    ActionUnit(4, "Brow Lowerer", {"procerus": 1.0, "depressor_supercilii": 1.0, "corrugator_supercilii": 1.0}),
    ActionUnit(5, "Upper Lid Raiser", poses={_LID: -0.3}, substitutes={_LEVATOR: 1.0}),
    ActionUnit(6, "Cheek Raiser", {_ORBITAL: 1.0}),
    ActionUnit(7, "Lid Tightener", {_PALPEBRAL: 1.0}, {_LID: 0.1}),
    _lips(8, "Lips Toward Each Other", marginal=0.5, peripheral=0.5),
    ActionUnit(9, "Nose Wrinkler", {"levator_labii_superioris_alaeque_nasi": 1.0}),
    ActionUnit(10, "Upper Lip Raiser", {"levator_labii_superioris": 1.0}),
    ActionUnit(11, "Nasolabial Furrow Deepener", {"zygomaticus_minor": 1.0}),
    ActionUnit(12, "Lip Corner Puller", {"zygomaticus_major": 1.0}),
    ActionUnit(13, "Cheek Puffer", {"levator_anguli_oris": 1.0}),
    ActionUnit(14, "Dimpler", {"buccinator": 1.0}),
    ActionUnit(15, "Lip Corner Depressor", {"depressor_anguli_oris": 1.0}),
    ActionUnit(16, "Lower Lip Depressor", {"depressor_labii_inferioris": 1.0}),
    ActionUnit(17, "Chin Raiser", {"mentalis": 1.0}),
    ActionUnit(
        18,
        "Lip Puckerer",
        {
            "incisivus_labii_superioris": 1.0,
            "incisivus_labii_inferioris": 1.0,
            **_upper_and_lower({_MARGINAL: 0.8, _PERIPHERAL: 0.7}),
        },
        substitutes={_PERIPHERAL: 1.0},
    ),
    ActionUnit(20, "Lip Stretcher", {"risorius": 1.0}),
    ActionUnit(21, "Neck Tightener", {"platysma": 1.0}),  # not in Table 7.2; in FACS
    _lips(22, "Lip Funneler", peripheral=0.8),
    _lips(23, "Lip Tightener", marginal=1.0, held=0.5),
    _lips(24, "Lip Pressor", marginal=1.0, peripheral=0.4, held=0.8),
    ActionUnit(25, "Lips Part", {"depressor_labii_inferioris": 0.5}),
    ActionUnit(26, "Jaw Drop", poses={"jaw_open": 0.5}),
    ActionUnit(27, "Mouth Stretch", poses={"jaw_open": 1.0}),
    _lips(28, "Lip Suck", marginal=1.0, peripheral=0.2, held=0.8),
    ActionUnit(38, "Nostril Dilator", {"nasalis_alaris": 1.0}),
    ActionUnit(39, "Nostril Compressor", {"nasalis_transversa": 1.0, "depressor_septi_nasi": 1.0}),
    ActionUnit(41, "Lid Droop", poses={_LID: 0.4}),
    ActionUnit(42, "Slit", {_PALPEBRAL: 0.4}, {_LID: 0.65}),
    ActionUnit(43, "Eyes Closed", poses={_LID: 1.0}),
    ActionUnit(44, "Squint", {_PALPEBRAL: 1.0}, {_LID: 0.5}),
    ActionUnit(45, "Blink", {_PALPEBRAL: 0.5}, {_LID: 1.0}),
    ActionUnit(46, "Wink", {_PALPEBRAL: 1.0, _ORBITAL: 0.5}, {_LID: 1.0}),
)

ACTION_UNITS: Mapping[str, ActionUnit] = MappingProxyType({f"AU{unit.number}": unit for unit in _ROWS})
