"""Plane geometry of the tracker. Angles in radians, counter-clockwise."""

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]

QUARTER = np.pi / 2


def rotate(vector: npt.NDArray[np.generic], angle: Floats | float) -> Floats:
    """Turn vectors (..., 2) by angles (...)."""
    cos, sin = np.cos(angle), np.sin(angle)
    x, y = vector[..., 0], vector[..., 1]
    return np.stack([cos * x - sin * y, sin * x + cos * y], axis=-1)


def wrap(angle: float) -> float:
    """Angle in [-pi, pi)."""
    return (angle + np.pi) % (2 * np.pi) - np.pi
