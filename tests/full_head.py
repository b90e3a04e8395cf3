"""The inputs of a head with every muscle that the built-in one has, a jaw and lids."""

from risorius.inputs import InputTable
from risorius.jaw import JawMotion
from risorius.lids import LidMotion

MUSCLES = (
    "zygomaticus_major",
    "zygomaticus_minor",
    "levator_labii_superioris",
    "levator_labii_superioris_alaeque_nasi",
    "levator_anguli_oris",
    "risorius",
    "buccinator",
    "depressor_anguli_oris",
    "depressor_labii_inferioris",
    "mentalis",
    "incisivus_labii_superioris",
    "incisivus_labii_inferioris",
    "orbicularis_oris_marginalis_superior",
    "orbicularis_oris_marginalis_inferior",
    "orbicularis_oris_peripheralis_superior",
    "orbicularis_oris_peripheralis_inferior",
    "orbicularis_oculi_orbitalis",
    "orbicularis_oculi_palpebralis",
    "frontalis_medialis",
    "frontalis_lateralis",
    "corrugator_supercilii",
    "depressor_supercilii",
    "procerus",
    "nasalis_alaris",
    "nasalis_transversa",
    "depressor_septi_nasi",
    "platysma",
)
POSES = (*JawMotion.inputs, *LidMotion.inputs)
HEAD = InputTable(tuple(f"{muscle}_{side}" for muscle in MUSCLES for side in "LR"), POSES)
