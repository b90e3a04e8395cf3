"""What the full model is made from, and its file."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import numpy.typing as npt

from risorius import storage
from risorius.companion import Companion, read_companions, write_companions
from risorius.errors import InputError
from risorius.inputs import InputTable
from risorius.jaw import FloatArray, JawMotion
from risorius.lids import LidMotion
from risorius.mechanics.material import Yeoh
from risorius.poses import Poses
from risorius.surface import CarriedSurface
from risorius_offline.discretisation import CellBlock, IntArray
from risorius_offline.muscles.muscle import Muscle

SCHEMA = "risorius-anatomy"
SCHEMA_VERSION = 3
LEFT_LID, RIGHT_LID = 1, 2


@dataclass(frozen=True)
class Surface:
    """A triangulated bone: points (n, 3) in metres, triangles (m, 3)."""

    points: FloatArray
    triangles: IntArray


@dataclass(frozen=True)
class Anatomy:
    """A meshed face in the frame x to the person's left, y up, z out of the face, metres.

    points (n, 3); cells with a layer number each, materials by layer number; skull, jaw (n,) flags of the nodes that
    move with the bone; skin (m, 3) the visible triangles, outward; jaw_motion is None without a mandible.
    lids: (n,) labels of the nodes of the upper tarsal plates, LEFT_LID or RIGHT_LID, 0 elsewhere; with lid_motion.
    epidermis: thickness in metres of a film on the skin, of the tissue beneath, that keeps its triangles from folding.
    surface: what is seen of the skin, None for the skin itself. companions: rigid things seen with it, by name.
    """

    name: str
    points: FloatArray
    cells: tuple[CellBlock, ...]
    materials: tuple[Yeoh, ...]
    skull: npt.NDArray[np.bool_]
    jaw: npt.NDArray[np.bool_]
    skin: IntArray
    muscles: tuple[Muscle, ...]
    jaw_motion: JawMotion | None
    lids: npt.NDArray[np.int8] | None = None
    lid_motion: LidMotion | None = None
    epidermis: float = 0.0
    bones: Mapping[str, Surface] = field(default_factory=dict)
    surface: CarriedSurface | None = None
    companions: Mapping[str, Companion] = field(default_factory=dict)
    provenance: Mapping[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        """Raise InputError for lids that move without nodes, and for a surface that another mesh carries."""
        if self.lid_motion is not None and self.lids is None:
            raise InputError(f"anatomy {self.name!r} has lid_motion but no lids; label the nodes of the tarsal plates")
        if self.surface is not None and self.surface.weights.shape[1] != len(self.points):
            raise InputError(
                f"anatomy {self.name!r}: surface carried by {self.surface.weights.shape[1]} nodes, the mesh has "
                f"{len(self.points)}; give one weight for each node"
            )

    @property
    def inputs(self) -> InputTable:
        """Inputs that this anatomy understands."""
        return InputTable(tuple(muscle.name for muscle in self.muscles), self.poses.inputs)

    @property
    def poses(self) -> Poses:
        """Prescribed motions."""
        return Poses(self.jaw_motion, self.lid_motion)

    @property
    def visible_surface(self) -> CarriedSurface:
        """Surface that is seen: `surface`, or the nodes of the skin."""
        return self.surface or CarriedSurface.of_nodes(self.points, self.skin)

    @property
    def prescribed(self) -> npt.NDArray[np.bool_]:
        """(n,) nodes whose displacement is prescribed: on skull, jaw or a tarsal plate."""
        bones = self.skull | self.jaw
        return bones if self.lids is None else bones | (self.lids != 0)

    def unit_motions(self) -> FloatArray:
        """(lifts, n, 3) displacement of the prescribed nodes for each lift coordinate of the poses; zero elsewhere."""
        fields = [np.zeros((0, *self.points.shape))]
        if self.jaw_motion is not None:
            fields.append(np.where(self.jaw[:, None], self.jaw_motion.unit_motions(self.points), 0.0))
        if self.lid_motion is not None and self.lids is not None:
            of_lid = self.lids == np.repeat([LEFT_LID, RIGHT_LID], 2)[:, None]
            fields.append(np.where(of_lid[..., None], self.lid_motion.unit_motions(self.points), 0.0))
        return np.concatenate(fields)

    def save(self, path: str | Path) -> None:
        """Write the anatomy file; it appears under its name only when complete."""
        with storage.writing(Path(path), SCHEMA, SCHEMA_VERSION) as file:
            self.write(file)

    @classmethod
    def load(cls, path: str | Path) -> Anatomy:
        """Read an anatomy file; raises InputError or FileFormatError."""
        with storage.reading(Path(path), SCHEMA, SCHEMA_VERSION) as file:
            return cls.read(file)

    def checksum(self) -> str:
        """SHA-256 over all that the anatomy file holds."""
        with h5py.File("anatomy", "w", driver="core", backing_store=False) as memory:
            self.write(memory)
            return storage.content_checksum(memory)

    def write(self, group: h5py.Group) -> None:
        """Store all fields in an HDF5 group."""
        group.attrs["name"] = self.name
        group.attrs["epidermis"] = self.epidermis
        group.attrs["provenance"] = json.dumps(dict(self.provenance), sort_keys=True)
        for key in ("points", "skull", "jaw", "skin"):
            group[key] = getattr(self, key)
        group["materials"] = np.array([[m.c10, m.c20, m.bulk] for m in self.materials])
        for block in self.cells:
            group[f"cells/{block.cell_type}/connectivity"] = block.connectivity
            group[f"cells/{block.cell_type}/layer"] = block.layer
        for number, muscle in enumerate(self.muscles):
            muscle.write(group.create_group(f"muscles/{number:03d}"))
        for name, bone in self.bones.items():
            group[f"bones/{name}/points"], group[f"bones/{name}/triangles"] = bone.points, bone.triangles
        if self.lids is not None:
            group["lids"] = self.lids
        if self.surface is not None:
            self.surface.write(group.create_group("surface"))
        write_companions(group, self.companions)
        self.poses.write(group)

    @classmethod
    def read(cls, group: h5py.Group) -> Anatomy:
        """Load what `write` stored."""
        cells = tuple(CellBlock(kind, b["connectivity"][()], b["layer"][()]) for kind, b in group["cells"].items())
        bones = {name: Surface(b["points"][()], b["triangles"][()]) for name, b in group.get("bones", {}).items()}
        poses = Poses.read(group)
        return cls(
            name=str(group.attrs["name"]),
            points=group["points"][()],
            cells=cells,
            materials=tuple(Yeoh(*(float(c) for c in row)) for row in group["materials"][()]),
            skull=group["skull"][()],
            jaw=group["jaw"][()],
            skin=group["skin"][()],
            muscles=tuple(Muscle.read(item) for item in group.get("muscles", {}).values()),
            jaw_motion=poses.jaw,
            lids=group["lids"][()] if "lids" in group else None,
            lid_motion=poses.lids,
            epidermis=float(group.attrs["epidermis"]),
            bones=bones,
            surface=CarriedSurface.read(group["surface"]) if "surface" in group else None,
            companions=read_companions(group),
            provenance=json.loads(group.attrs["provenance"]),
        )
