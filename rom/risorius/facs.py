"""Facial action units: number, name and muscular basis, after Table 7.2 of the seed (FACS, Ekman and Friesen).

Muscles carry the names of current anatomy in snake case; the seed's older names stand beside them: *triangularis*
is depressor anguli oris, *caninus* is levator anguli oris, *depressor labii* is depressor labii inferioris,
*depressor glabellae* is procerus. Where the table says "orbicularis oris" for five different actions, the marginal
part (which inverts and tightens the lip) and the peripheral part (which everts and puckers it) are told apart as in
Flynn et al. 2015. AU26 and AU27, given in the table as actions of the masticatory muscles, are motions of the mandible.
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
    """

    number: int
    name: str
    muscles: Mapping[str, float] = field(default_factory=dict)
    poses: Mapping[str, float] = field(default_factory=dict)
    substitutes: Mapping[str, float] = field(default_factory=dict)


_MARGINAL = "orbicularis_oris_marginalis"
_PERIPHERAL = "orbicularis_oris_peripheralis"

_ROWS = (
    ActionUnit(1, "Inner Brow Raiser", {"frontalis_medialis": 1.0}),
    ActionUnit(2, "Outer Brow Raiser", {"frontalis_lateralis": 1.0}),
    ActionUnit(4, "Brow Lowerer", {"procerus": 1.0, "depressor_supercilii": 1.0, "corrugator_supercilii": 1.0}),
    ActionUnit(5, "Upper Lid Raiser", {"levator_palpebrae_superioris": 1.0}),
    ActionUnit(6, "Cheek Raiser", {"orbicularis_oculi_orbitalis": 1.0}),
    ActionUnit(7, "Lid Tightener", {"orbicularis_oculi_palpebralis": 1.0}),
    ActionUnit(8, "Lips Toward Each Other", {_MARGINAL: 0.5, _PERIPHERAL: 0.5}),
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
        {"incisivus_labii_superioris": 1.0, "incisivus_labii_inferioris": 1.0},
        substitutes={_PERIPHERAL: 1.0},
    ),
    ActionUnit(20, "Lip Stretcher", {"risorius": 1.0}),
    ActionUnit(22, "Lip Funneler", {_PERIPHERAL: 0.8}),
    ActionUnit(23, "Lip Tightener", {_MARGINAL: 1.0}),
    ActionUnit(24, "Lip Pressor", {_MARGINAL: 0.7, _PERIPHERAL: 0.4}),
    ActionUnit(25, "Lips Part", {"depressor_labii_inferioris": 0.5}),
    ActionUnit(26, "Jaw Drop", poses={"jaw_open": 0.5}),
    ActionUnit(27, "Mouth Stretch", poses={"jaw_open": 1.0}),
    ActionUnit(28, "Lip Suck", {_MARGINAL: 1.0, _PERIPHERAL: 0.2}),
    ActionUnit(38, "Nostril Dilator", {"nasalis_alaris": 1.0}),
    ActionUnit(39, "Nostril Compressor", {"nasalis_transversa": 1.0, "depressor_septi_nasi": 1.0}),
)

ACTION_UNITS: Mapping[str, ActionUnit] = MappingProxyType({f"AU{unit.number}": unit for unit in _ROWS})
