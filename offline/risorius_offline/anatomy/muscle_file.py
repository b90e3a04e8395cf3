"""muscles.json of an import folder: units, frame, materials and muscles."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from risorius.errors import InputError
from risorius.jaw import FloatArray
from risorius.mechanics.material import Yeoh
from risorius_offline.anatomy.frame import Frame
from risorius_offline.anatomy.layers import MUSCLE_TO_SKIN, layer_materials
from risorius_offline.anatomy.muscle_entry import MuscleEntry, Placement, Positive
from risorius_offline.muscles.muscle import Muscle
from risorius_offline.muscles.region import Region

# Published values of the ArtiSynth face (Nazari et al. 2010, Flynn et al. 2015); bulk modulus 100 c10.
DEFAULT_TISSUE = Yeoh(c10=2500.0, c20=1175.0, bulk=250e3)


class MaterialEntry(BaseModel):
    """Yeoh coefficients in pascals of one layer."""

    model_config = ConfigDict(extra="forbid")

    c10: Positive
    c20: Annotated[float, Field(ge=0)] = 0.0
    bulk: Positive


class LayersEntry(BaseModel):
    """Instead of materials: the documented layers, with the ratio of muscle to skin stiffness."""

    model_config = ConfigDict(extra="forbid")

    muscle_to_skin: Positive = MUSCLE_TO_SKIN


class MuscleFile(BaseModel):
    """The whole file. `units` are those of the mesh and the bones."""

    units: str
    frame: str
    materials: list[MaterialEntry] | None = None
    layers: LayersEntry | None = None
    muscles_: Annotated[list[MuscleEntry], Field(alias="muscles", min_length=1)]

    @property
    def layer_materials(self) -> tuple[Yeoh, ...]:
        """Material of every layer number; the published tissue when the file names none."""
        if self.layers is not None:
            if self.materials is not None:
                raise InputError("muscles.json: it has 'materials' and 'layers'; give one of them")
            return layer_materials(self.layers.muscle_to_skin)
        if self.materials is None:
            return (DEFAULT_TISSUE,)
        return tuple(Yeoh(entry.c10, entry.c20, entry.bulk) for entry in self.materials)

    @property
    def region_ids(self) -> tuple[str, ...]:
        """Ids of the muscles whose cells and areas the mesh marks."""
        return tuple(entry.id for entry in self.muscles_ if entry.region is not None)

    def muscles(self, frame: Frame, origin: FloatArray, regions: Mapping[str, Region]) -> tuple[Muscle, ...]:
        """Muscles in our frame, both sides; `name_L` is the person's left. Regions by the id of their muscle."""
        placement = Placement(frame.rotation, origin)
        return tuple(muscle for entry in self.muscles_ for muscle in entry.muscles(placement, regions))


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
