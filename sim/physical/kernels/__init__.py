"""Kernels of the truth layer, one body at a time: many numpy calls on few bodies would be slower."""
