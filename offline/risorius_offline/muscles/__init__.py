"""Muscles: fibre constructions (where a muscle pulls and along which direction) and loads (how it pulls).

A new construction is one file here with a class that satisfies `fibres.Fibres`, and one line in `muscle.CONSTRUCTIONS`.
"""
