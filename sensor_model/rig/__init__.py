"""Rigs, units and beam tables."""
