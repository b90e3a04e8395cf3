"""Offline: anatomy, finite elements, muscle fibres, equilibria, snapshots."""
