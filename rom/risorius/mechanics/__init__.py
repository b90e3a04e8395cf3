"""Constitutive laws and element integration, shared by the full and the reduced model."""
