"""Whether a mouth that went back had to."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from risorius.effects.contact import Contact
from risorius.jaw import FloatArray
from risorius.model import ReducedModel
from risorius.penetration import PenetrationMeasure
from risorius.reconstruction import reconstruction

DEEP = 0.2e-3  # metres: less than what calls for going back, since contact looks at fewer points than the measure


class GoingBack:
    """Looks at what contact (its state is its own) of a model would show without going back, and by which measure."""

    def __init__(self, model: ReducedModel, contact: Contact, measure: PenetrationMeasure) -> None:
        self._model, self._contact, self._measure = model, contact, measure
        basis = model.carried_basis.followed_by([effect.fields for effect in model.effects.values()])
        self._surface = reconstruction(basis, model.rest_vertices)

    def needed(self, coordinates: FloatArray) -> bool:
        """Whether at coordinates (r,) of a frame that nothing touches skin is DEEP before contact and after sweeps."""
        vertices = np.empty_like(self._model.rest_vertices)
        self._surface.write(coordinates, vertices)
        if not self._deep(vertices, coordinates):
            return False
        self._contact.sweep(coordinates, vertices)
        return self._deep(vertices, coordinates)

    def _deep(self, vertices: npt.NDArray[np.float32], coordinates: FloatArray) -> bool:
        found = self._measure(vertices, coordinates[: self._model.rank])
        return max(found.teeth, found.lips) > DEEP
