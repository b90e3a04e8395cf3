"""ARKit's 52 blend shapes as action units and poses; sources of every row: docs/facs.md.

`Left` and `Right` are the face's own: "the left and right directions are relative to the face" (Apple,
ARFaceAnchor.BlendShapeLocation). Every coefficient is linear, what several ask of one input adds up, to 1 at most.
"""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from types import MappingProxyType

from risorius.errors import InputError

_SIDES = (("Left", "_L"), ("Right", "_R"))

_ONE_SIDED: Mapping[str, Mapping[str, float]] = {
    "browDown": {"AU4": 1.0},
    "browOuterUp": {"AU2": 1.0},
    "cheekSquint": {"AU6": 1.0},
    "eyeBlink": {"AU43": 1.0},
    "eyeSquint": {"AU7": 1.0},
    "eyeWide": {"AU5": 1.0},
    "mouth": {"AU14": 0.5, "AU20": 0.5},
    "mouthDimple": {"AU14": 1.0},
    "mouthFrown": {"AU15": 1.0},
    "mouthLowerDown": {"AU16": 1.0},
    "mouthPress": {"AU24": 1.0},
    "mouthSmile": {"AU12": 1.0},
    "mouthStretch": {"AU20": 1.0},
    "mouthUpperUp": {"AU10": 1.0},
    "noseSneer": {"AU9": 1.0},
}
_OF_BOTH_SIDES: Mapping[str, Mapping[str, float]] = {
    "browInnerUp": {"AU1": 1.0},
    "jawForward": {"jaw_forward": 1.0},
    "jawLeft": {"jaw_sideways": 1.0},  # the model's x goes to the person's left
    "jawRight": {"jaw_sideways": -1.0},
    "jawOpen": {"jaw_open": 1.0},
    "mouthClose": {"AU8": 1.0},
    "mouthFunnel": {"AU22": 1.0},
    "mouthPucker": {"AU18": 1.0},
    "mouthRollLower": {"AU28": 0.5},
    "mouthRollUpper": {"AU28": 0.5},
    "mouthShrugLower": {"AU17": 0.5},
    "mouthShrugUpper": {"AU17": 0.5},
}

DRIVES: Mapping[str, Mapping[str, float]] = MappingProxyType(
    {
        **{
            f"{stem}{side}": {f"{name}{suffix}": share for name, share in shares.items()}
            for stem, shares in _ONE_SIDED.items()
            for side, suffix in _SIDES
        },
        **_OF_BOTH_SIDES,
    }
)
"""Inputs that each blend shape drives, with their weights at coefficient 1."""

WITHOUT_EFFECT = frozenset(
    {f"eyeLook{way}{side}" for way in ("Down", "In", "Out", "Up") for side, _ in _SIDES} | {"cheekPuff", "tongueOut"}
)
"""Blend shapes that move no tissue of the model: gaze, tongue, and air in the cheeks."""


def action_units(coefficients: Mapping[str, float]) -> dict[str, float]:
    """Weights by input name, ready for `Engine.evaluate`, of ARKit coefficients in [0, 1].

    Shapes without an effect are ignored; a warning says so, which Python shows once. Raises InputError for a name that
    is not ARKit's and for a coefficient that is not a number in [0, 1].
    """
    weights: dict[str, float] = {}
    ignored = []
    for shape, coefficient in coefficients.items():
        if not 0.0 <= coefficient <= 1.0:
            raise InputError(f"{shape}: coefficient {coefficient!r} is out of range; give a number in [0, 1]")
        if shape in WITHOUT_EFFECT:
            ignored.append(shape)
            continue
        if shape not in DRIVES:
            raise InputError(f"{shape!r} is not a blend shape of ARKit; write for example jawOpen or mouthSmileLeft")
        for name, share in DRIVES[shape].items():
            weights[name] = weights.get(name, 0.0) + share * coefficient
    if ignored:
        warnings.warn("ARKit's gaze, tongue and cheekPuff move no tissue of the model: ignored", stacklevel=2)
    return {name: min(weight, 1.0) for name, weight in weights.items()}
