"""Fibre constructions: where a muscle is active, and along which direction. One construction a file."""
