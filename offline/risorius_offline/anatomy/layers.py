"""Materials of the layers of a face, with the ratio of muscle to skin stiffness as the parameter that decides (7.5)."""

from __future__ import annotations

from risorius.errors import InputError
from risorius.mechanics.material import Yeoh

# Young's moduli (Pa) of a set that gives a plausible smile, from the outside inwards: the layer numbers of a mesh.
SKIN, SUPERFICIAL_FAT, MUSCLE, DEEP_FAT = 40e3, 5e3, 15e3, 6e3
LAYERS = ("skin", "superficial fat", "muscle", "deep fat")
POISSON = 0.45
MUSCLE_TO_SKIN = MUSCLE / SKIN


def layer_materials(muscle_to_skin: float = MUSCLE_TO_SKIN) -> tuple[Yeoh, ...]:
    """Neo-Hookean materials of `LAYERS` for a ratio E_M / E_S of Young's moduli.

    Skin keeps its modulus and muscle takes `muscle_to_skin` of it; both fats are as in the base set. Raises InputError
    for a ratio that is not positive.
    """
    if not muscle_to_skin > 0.0:
        raise InputError(f"layers: muscle_to_skin = {muscle_to_skin:g}; give a positive ratio of Young's moduli")
    moduli = (SKIN, SUPERFICIAL_FAT, muscle_to_skin * SKIN, DEEP_FAT)
    return tuple(Yeoh.neo_hookean(modulus, POISSON) for modulus in moduli)
