"""One muscle of muscles.json: its construction, its load, and how it is placed in our frame, on one side or both."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Annotated, Any, Literal, TypeAlias

import numpy as np
from pydantic import BaseModel, ConfigDict, Field

from risorius.errors import InputError
from risorius.jaw import FloatArray
from risorius_offline.muscles.deformation_fibres import Capsule, DeformationFibres
from risorius_offline.muscles.ellipse import Ellipse
from risorius_offline.muscles.fibres import Fibres
from risorius_offline.muscles.insertion_cone import TABLE_7_3, InsertionCone
from risorius_offline.muscles.laplace_fibres import LaplaceFibres
from risorius_offline.muscles.loads import ActiveStress, ForceDensity, Insertion, Load
from risorius_offline.muscles.muscle import Muscle
from risorius_offline.muscles.polyline_fibres import PolylineFibres
from risorius_offline.muscles.radial_fibres import RadialFibres
from risorius_offline.muscles.region import Region
from risorius_offline.muscles.ring_fibres import RingFibres
from risorius_offline.muscles.spline_fibres import SplineFibres

DEFAULT_RADIUS, DEFAULT_STRESS = 0.006, 100e3  # of the ArtiSynth face (Nazari et al. 2010, Flynn et al. 2015)

Point = tuple[float, float, float]
Line = Annotated[list[Point], Field(min_length=2)]
Lines = Annotated[list[Line], Field(min_length=1)]
Positive = Annotated[float, Field(gt=0)]
Radius: TypeAlias = Positive | tuple[Positive, Positive]  # of a tube, or at the origin and at the insertion


@dataclass(frozen=True)
class Placement:
    """From the source's axes into ours: rotation (3, 3), then the origin (3,) in our axes, then a reflection (3,)."""

    rotation: FloatArray
    origin: FloatArray
    reflection: tuple[float, float, float] = (1.0, 1.0, 1.0)

    @property
    def mirrored(self) -> Placement:
        """The same on the other side of the face."""
        return replace(self, reflection=(-1.0, 1.0, 1.0))

    def points(self, points: list[Point]) -> FloatArray:
        """(k, 3) metres."""
        return ((self.rotation @ np.array(points).T).T - self.origin) * self.reflection

    def vector(self, vector: Point) -> FloatArray:
        """(3,)."""
        return self.rotation @ np.array(vector) * self.reflection


class Entry(BaseModel):
    """A part of an entry; unknown keys are refused."""

    model_config = ConfigDict(extra="forbid")


class RegionEntry(Entry):
    """Fibres from the cells and areas that the mesh marks: the boundary value problem and its parameters."""

    method: Literal["laplace", "deformation"]
    poisson: Annotated[float, Field(ge=0, lt=0.5)] = 0.3
    capsule: Capsule = "sliding"

    def fibres(self, region: Region) -> Fibres:
        """The construction on a region."""
        return (
            LaplaceFibres(region) if self.method == "laplace" else DeformationFibres(region, self.poisson, self.capsule)
        )


class EllipseEntry(Entry):
    """Middle line of a sphincter."""

    centre_m: Point
    normal: Point
    first_axis: Point
    semi_axes_m: tuple[Positive, Positive]

    def placed(self, placement: Placement) -> Ellipse:
        """The ellipse in our frame."""
        (centre,) = placement.points([self.centre_m])
        normal, first = placement.vector(self.normal), placement.vector(self.first_axis)
        return Ellipse(tuple(centre.tolist()), tuple(normal.tolist()), tuple(first.tolist()), self.semi_axes_m)


class InsertionEntry(Entry):
    """Insertion cone; radius and apex angle from Table 7.3 where it has the muscle."""

    magnitude_n_m3: Positive
    radius_m: Positive | None = None
    apex_angle_deg: Annotated[float, Field(gt=0, lt=180)] | None = None

    def cone(self, muscle: str) -> InsertionCone:
        """The cone of a muscle; raises InputError for one that neither the entry nor the table describes."""
        if self.radius_m is not None and self.apex_angle_deg is not None:
            return InsertionCone(self.radius_m, math.radians(self.apex_angle_deg))
        if muscle not in TABLE_7_3:
            raise InputError(
                f"insertion: Table 7.3 has no {muscle!r} (it has {', '.join(TABLE_7_3)}); "
                "give 'radius_m' and 'apex_angle_deg'"
            )
        listed = TABLE_7_3[muscle]
        angle = listed.apex_angle if self.apex_angle_deg is None else math.radians(self.apex_angle_deg)
        return InsertionCone(self.radius_m or listed.radius, angle)


class ForceDensityEntry(Entry):
    """Force density (7.3)."""

    magnitude_n_m3: Positive
    insertion: InsertionEntry | None = None


class MuscleEntry(BaseModel):
    """One muscle, with exactly one construction: `region` or a key of `BUILDERS`; metres, in the source's axes."""

    id: str
    name: str
    side: Literal["L", "R"] | None = None
    fibres_m: Lines | None = None
    fibres_one_side_m: Lines | None = None
    splines_m: Lines | None = None
    splines_one_side_m: Lines | None = None
    ring: EllipseEntry | None = None
    ring_one_side: EllipseEntry | None = None
    radial: EllipseEntry | None = None
    radial_one_side: EllipseEntry | None = None
    region: RegionEntry | None = None
    radius_m: Radius = DEFAULT_RADIUS
    max_stress_pa: Positive | None = None
    force_density: ForceDensityEntry | None = None

    def muscles(self, placement: Placement, regions: Mapping[str, Region]) -> list[Muscle]:
        """The muscle, or the left one and the right one of two; regions by the id of their muscle.

        Raises InputError that names the muscle and the key.
        """
        try:
            load = self._load()
            return [Muscle(name, fibres, load) for name, fibres in self._placed(placement, regions)]
        except InputError as error:
            raise InputError(f"muscles.json: muscle {self.id!r}: {error}") from error

    def _placed(self, placement: Placement, regions: Mapping[str, Region]) -> list[tuple[str, Fibres]]:
        """Name and fibres of each side."""
        keys = (*BUILDERS, "region")
        given = [key for key in keys if getattr(self, key) is not None]
        if len(given) != 1:
            raise InputError(f"it has {' and '.join(given) or 'no fibres'}; give exactly one of {', '.join(keys)}")
        (key,) = given
        if self.region is not None:
            return [(self._named(self.side), self.region.fibres(regions[self.id]))]
        value, build = getattr(self, key), BUILDERS[key]
        here = build(value, self.radius_m, placement)
        if not key.endswith(("_one_side", "_one_side_m")):
            return [(self._named(self.side), here)]
        if self.side is not None:
            raise InputError(f"side: {self.side!r} contradicts {key!r}, which makes both sides; leave one of them out")
        there = build(value, self.radius_m, placement.mirrored)
        left_first = (here, there) if _lies_left(value, placement) else (there, here)
        return [(self._named(side), fibres) for side, fibres in zip("LR", left_first, strict=True)]

    def _named(self, side: str | None) -> str:
        return f"{self._base_name}_{side}" if side else self._base_name

    @property
    def _base_name(self) -> str:
        return re.sub(r"[^a-z0-9]+", "_", self.name.lower()).strip("_")

    def _load(self) -> Load:
        if self.force_density is None:
            return ActiveStress(DEFAULT_STRESS if self.max_stress_pa is None else self.max_stress_pa)
        if self.max_stress_pa is not None:
            raise InputError("it has 'max_stress_pa' and 'force_density'; give one of them")
        entry = self.force_density.insertion
        insertion = Insertion(entry.cone(self._base_name), entry.magnitude_n_m3) if entry else None
        return ForceDensity(self.force_density.magnitude_n_m3, insertion)


def _polylines(lines: list[Line], radius: Radius, placement: Placement) -> Fibres:
    return PolylineFibres(tuple(placement.points(line) for line in lines), _single(radius))


def _splines(lines: list[Line], radius: Radius, placement: Placement) -> Fibres:
    radii = radius if isinstance(radius, tuple) else (radius, radius)
    return SplineFibres(tuple(placement.points(line) for line in lines), *radii)


def _ring(ellipse: EllipseEntry, radius: Radius, placement: Placement) -> Fibres:
    return RingFibres(ellipse.placed(placement), _single(radius))


def _radial(ellipse: EllipseEntry, radius: Radius, placement: Placement) -> Fibres:
    return RadialFibres(ellipse.placed(placement), _single(radius))


def _single(radius: Radius) -> float:
    if isinstance(radius, tuple):
        raise InputError(f"radius_m: a pair {radius} goes with splines only; give one number")
    return radius


def _lies_left(value: list[Line] | EllipseEntry, placement: Placement) -> bool:
    points = [value.centre_m] if isinstance(value, EllipseEntry) else [point for line in value for point in line]
    return bool(placement.points(points)[:, 0].mean() > 0.0)


# Keys of the constructions that need no marks in the mesh; those of one side are mirrored for the other.
BUILDERS: dict[str, Callable[[Any, Radius, Placement], Fibres]] = {
    "fibres_one_side_m": _polylines,
    "fibres_m": _polylines,
    "splines_one_side_m": _splines,
    "splines_m": _splines,
    "ring_one_side": _ring,
    "ring": _ring,
    "radial_one_side": _radial,
    "radial": _radial,
}
