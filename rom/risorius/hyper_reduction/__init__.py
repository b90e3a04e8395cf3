"""Hyper-reduction: the physics of a face on few weighted elements, for modal coordinates, in microseconds.

Terms of the energy (`terms`) hold elements of one kind side by side; cubature (`cubature`) chooses few of them and
their weights; `ReducedBody` sums the terms for reduced coordinates, and `correction` brings coordinates closer to
equilibrium. A new term is one file with a class that satisfies `terms.Term`.
"""
