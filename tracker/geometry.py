"""Plane geometry of the tracker. Angles in radians, counter-clockwise."""

from typing import Any

import numpy as np
import numpy.typing as npt

from luxloop import elementary, elementwise
from luxloop.arrays import Floats

QUARTER = np.pi / 2


def rotate(vector: npt.NDArray[Any], angle: Floats | float) -> Floats:
    """Rotate vectors (..., 2) by angles (...)."""
    cos, sin = elementwise.cos(angle), elementwise.sin(angle)
    x, y = vector[..., 0], vector[..., 1]
    first = cos * x - sin * y
    turned = np.empty((*first.shape, 2))
    turned[..., 0] = first
    turned[..., 1] = sin * x + cos * y
    return turned


def rotate_one(vector: npt.NDArray[np.generic], angle: float) -> Floats:
    """Rotate one vector (2,) by an angle, as `rotate` but without the cost of array operations."""
    x, y = vector.tolist()
    cos, sin = elementary.cos(angle), elementary.sin(angle)
    return np.array([cos * x - sin * y, sin * x + cos * y])


def wrap(angle: float) -> float:
    """Angle in [-pi, pi)."""
    return (angle + np.pi) % (2 * np.pi) - np.pi


def fold(heading: Floats) -> Floats:
    """Headings modulo a quarter turn, in [0, pi/2)."""
    # The remainder of a tiny negative angle rounds to pi/2.
    remainder = np.mod(heading, QUARTER)
    return np.asarray(np.where(remainder < QUARTER, remainder, 0.0))


def rotated_covariance(variance: Floats, heading: float) -> Floats:
    """(2, 2) covariance with variances (2,) along and across a heading."""
    (along, across), cos, sin = variance.tolist(), elementary.cos(heading), elementary.sin(heading)
    cc, cs, ss = cos * cos, cos * sin, sin * sin
    mixed = cs * (along - across)
    return np.array([[cc * along + ss * across, mixed], [mixed, ss * along + cc * across]])


def variance_along(covariance: Floats, heading: float) -> Floats:
    """(2,) variances of a covariance (2, 2) along and across a heading."""
    cos, sin = elementary.cos(heading), elementary.sin(heading)
    (xx, xy), (yx, yy) = covariance.tolist()

    def along(x: float, y: float) -> float:
        return float((x * xx * x + x * xy * y) + (y * yx * x + y * yy * y))

    return np.array([along(cos, sin), along(-sin, cos)])


def mahalanobis(residual: Floats, covariance: Floats) -> tuple[Floats, Floats]:
    """Squared Mahalanobis distance (...) of residuals (..., 2), and determinant (...) of their covariance (..., 2, 2).

    Closed form for two dimensions: the general inverse is several times slower on many small matrices.
    """
    x, y = residual[..., 0], residual[..., 1]
    xx, xy, yy = covariance[..., 0, 0], covariance[..., 0, 1], covariance[..., 1, 1]
    determinant = xx * yy - xy**2
    return (yy * x**2 - 2 * xy * x * y + xx * y**2) / determinant, determinant
