"""Noise between the world and the reported points. Each kind has its own switch, strength and `Cause`."""
