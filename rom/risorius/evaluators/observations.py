"""What a learned map is fitted to: modal coordinates of snapshots and their derivatives by the parameters."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from risorius.jaw import FloatArray


@dataclass(frozen=True)
class Reflection:
    """The other side of a face that is its own mirror image.

    partner (p,): parameter that does on the other side what this one does here, itself on the midline. sign (p,): -1
    where the parameter changes its sign there, as a sideways jaw does. parity (r,): 1 for modes that are their own
    mirror image, -1 for those that are its opposite.
    """

    partner: npt.NDArray[np.int64]
    sign: FloatArray
    parity: FloatArray


@dataclass(frozen=True)
class Observations:
    """Snapshots as a map sees them.

    parameters (s, p), of which the first `muscles` are activations, and the smallest admissible value of each, lowest
    (p,); coordinates (s, r); derivatives (s, p, r) of the coordinates, None where they are not known; overlap (p, p) in
    [0, 1] of the displacement fields of single actions, and their sizes (p,); reflection: None where the face is not
    symmetric.
    """

    parameters: FloatArray
    coordinates: FloatArray
    derivatives: npt.NDArray[np.float32] | None
    muscles: int
    lowest: FloatArray
    overlap: FloatArray
    sizes: FloatArray
    reflection: Reflection | None = None

    def both_sides(self) -> Observations:
        """These and their mirror images, where the face is symmetric."""
        if self.reflection is None:
            return self
        partner, sign, parity = self.reflection.partner, self.reflection.sign, self.reflection.parity
        derivatives = self.derivatives
        if derivatives is not None:
            mirrored = derivatives[:, partner] * (sign[:, None] * parity).astype(np.float32)
            derivatives = np.concatenate([derivatives, mirrored])
        return replace(
            self,
            parameters=np.concatenate([self.parameters, self.parameters[:, partner] * sign]),
            coordinates=np.concatenate([self.coordinates, self.coordinates * parity]),
            derivatives=derivatives,
        )

    def thinned(self, most: int) -> Observations:
        """At most so many of the snapshots, evenly chosen."""
        return self.only(
            np.unique(np.linspace(0, len(self.parameters) - 1, min(most, len(self.parameters))).astype(np.int64))
        )

    def only(self, rows: npt.NDArray[np.int64]) -> Observations:
        """Some of the snapshots, by their numbers."""
        derivatives = None if self.derivatives is None else self.derivatives[rows]
        return replace(
            self, parameters=self.parameters[rows], coordinates=self.coordinates[rows], derivatives=derivatives
        )

    def symmetrised(self, matrix: FloatArray) -> FloatArray:
        """Mean of a matrix (p, p) of parameters and its mirror image."""
        if self.reflection is None:
            return matrix
        partner = self.reflection.partner
        return 0.5 * (matrix + matrix[np.ix_(partner, partner)])
