"""Isotropic hyperelastic tissue: Yeoh, of which neo-Hookean is the case c20 = 0."""

from __future__ import annotations

from dataclasses import dataclass

from risorius.errors import InputError

TISSUE_DENSITY = 1040.0  # kg/m3 (Nazari et al. 2010)
# Rayleigh damping of tissue, alpha in 1/s and beta in s (Flynn et al. 2015).
MASS_DAMPING, STIFFNESS_DAMPING = 19.0, 0.055


@dataclass(frozen=True)
class Yeoh:
    """Yeoh energy with a logarithmic barrier against J = 0 (Yeoh 1993; the barrier as in Simo and Pister 1984).

        psi = c10 (I1 - 3) + c20 (I1 - 3)^2 - 2 c10 ln J + lam/2 (ln Jbar)^2

    I1 = tr F^T F, J = det F, Jbar the mean of J over the element (over the point, without mean dilatation).
    c10, c20 and bulk in pascals; 2 c10 is the initial shear modulus, lam = bulk - 4/3 c10 the first Lame parameter.
    """

    c10: float
    c20: float
    bulk: float

    def __post_init__(self) -> None:
        if not (self.c10 > 0 and self.c20 >= 0 and self.bulk > 4.0 / 3.0 * self.c10):
            raise InputError(
                f"material: c10 = {self.c10:g}, c20 = {self.c20:g}, bulk = {self.bulk:g} Pa; "
                "c10 > 0, c20 >= 0 and bulk > 4/3 c10 (Poisson's ratio above 0) are needed"
            )

    @classmethod
    def neo_hookean(cls, young: float, poisson: float) -> Yeoh:
        """Neo-Hookean material of Young's modulus (Pa) and Poisson's ratio in (0, 0.5)."""
        if not 0.0 < poisson < 0.5:
            raise InputError(f"material: Poisson's ratio {poisson:g}; give a number between 0 and 0.5")
        return cls(c10=young / (4.0 * (1.0 + poisson)), c20=0.0, bulk=young / (3.0 * (1.0 - 2.0 * poisson)))

    @property
    def lame(self) -> float:
        """First Lame parameter, Pa."""
        return self.bulk - 4.0 / 3.0 * self.c10

    @property
    def coefficients(self) -> tuple[float, float, float]:
        """(c10, c20, lam) as the element kernels take them."""
        return self.c10, self.c20, self.lame
