"""Compiled loops over the solids of bodies."""
