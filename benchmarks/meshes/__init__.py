"""Meshes of the benchmarks: refinement, splits into other elements, and the problems they are measured on."""
