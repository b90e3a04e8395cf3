"""muscles.json of an import folder: units, frame, materials and fibre lines."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Annotated

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, ValidationError

from risorius.errors import InputError
from risorius.jaw import FloatArray
from risorius.mechanics.material import Yeoh
from risorius_offline.anatomy.anatomy import Muscle
from risorius_offline.anatomy.frame import Frame

# Published values of the ArtiSynth face (Nazari et al. 2010, Flynn et al. 2015); bulk modulus 100 c10.
DEFAULT_TISSUE = Yeoh(c10=2500.0, c20=1175.0, bulk=250e3)
DEFAULT_RADIUS, DEFAULT_STRESS = 0.006, 100e3

Point = tuple[float, float, float]
Line = Annotated[list[Point], Field(min_length=2)]
Positive = Annotated[float, Field(gt=0)]


class MaterialEntry(BaseModel):
    """Yeoh coefficients in pascals of one layer."""

    model_config = ConfigDict(extra="forbid")

    c10: Positive
    c20: Annotated[float, Field(ge=0)] = 0.0
    bulk: Positive


class MuscleEntry(BaseModel):
    """One muscle: fibre lines of one side, to be mirrored, or fibre lines as they are; metres."""

    id: str
    name: str
    fibres_one_side_m: list[Line] | None = None
    fibres_m: list[Line] | None = None
    radius_m: Positive = DEFAULT_RADIUS
    max_stress_pa: Positive = DEFAULT_STRESS


class MuscleFile(BaseModel):
    """The whole file. `units` are those of the mesh and the bones."""

    units: str
    frame: str
    materials: list[MaterialEntry] | None = None
    muscles_: Annotated[list[MuscleEntry], Field(alias="muscles", min_length=1)]

    @property
    def layer_materials(self) -> tuple[Yeoh, ...]:
        """Material of every layer number; the published tissue when the file names none."""
        if self.materials is None:
            return (DEFAULT_TISSUE,)
        return tuple(Yeoh(entry.c10, entry.c20, entry.bulk) for entry in self.materials)

    def muscles(self, frame: Frame, origin: FloatArray) -> tuple[Muscle, ...]:
        """Muscles in our frame, both sides; `name_L` is the person's left."""
        result: list[Muscle] = []
        for entry in self.muscles_:
            name = re.sub(r"[^a-z0-9]+", "_", entry.name.lower()).strip("_")
            if (entry.fibres_one_side_m is None) == (entry.fibres_m is None):
                raise InputError(
                    f"muscles.json: muscle {entry.id!r} needs either 'fibres_one_side_m' or 'fibres_m', not both"
                )
            lines = [frame.rotation @ np.array(line).T for line in entry.fibres_one_side_m or entry.fibres_m or []]
            given = tuple(np.ascontiguousarray(line.T) - origin for line in lines)
            if entry.fibres_m is not None:
                result.append(Muscle(name, given, entry.radius_m, entry.max_stress_pa))
                continue
            mirrored = tuple(line * np.array([-1.0, 1.0, 1.0]) for line in given)
            left_first = (given, mirrored) if np.concatenate(given)[:, 0].mean() > 0 else (mirrored, given)
            for side, side_lines in zip("LR", left_first, strict=True):
                result.append(Muscle(f"{name}_{side}", side_lines, entry.radius_m, entry.max_stress_pa))
        return tuple(result)


def read_muscle_file(path: Path) -> MuscleFile:
    """Read and validate muscles.json; raises InputError that names the field, its value and the remedy."""
    if not path.is_file():
        raise InputError(f"{path}: no such file; the import folder needs it (see docs/import.md)")
    try:
        return MuscleFile.model_validate(json.loads(path.read_text(encoding="utf-8")))
    except json.JSONDecodeError as error:
        raise InputError(f"{path}: not JSON ({error}); mend that line") from error
    except ValidationError as error:
        first = error.errors()[0]
        field = ".".join(str(part) for part in first["loc"])
        raise InputError(f"{path}: field {field}: {first['msg']} (found {first['input']!r:.80})") from error
