"""Weights for smoothing evenly sampled positions with a cubic B-spline kernel, and for the derivatives."""

import math

import numpy as np

from luxloop.arrays import Floats


def smoothing_weights(half: int) -> Floats:
    """Return smoothing weights (2 half + 1,) whose kernel spans the window; their sum is 1."""
    weight = _cubic(_grid(half))
    return np.asarray(weight / weight.sum())


def velocity_weights(half: int, dt: float) -> Floats:
    """Return weights (2 half + 1,) of the smoothed path's first derivative [1/s]; exact for constant speed."""
    time = dt * np.arange(-half, half + 1)
    weight = -_cubic_slope(_grid(half)) if half > 1 else np.array([-1.0, 0.0, 1.0])
    return weight / math.fsum(weight * time)


def acceleration_weights(half: int, dt: float) -> Floats:
    """Return weights (2 half + 1,) of its second derivative [1/s^2]; exact for constant acceleration."""
    time = dt * np.arange(-half, half + 1)
    weight = _cubic_bend(_grid(half)) if half > 1 else np.array([1.0, -2.0, 1.0])
    weight -= weight.mean()
    return weight / math.fsum(weight * time**2 / 2)


def _grid(half: int) -> Floats:
    """Return the sample times of the window in knot spacings; the kernel's support is (-2, 2)."""
    return 2 * np.arange(-half, half + 1) / (half + 1)


def _cubic(t: Floats) -> Floats:
    """Return the cubic B-spline (de Boor, "A Practical Guide to Splines", 1978, ch. IX), with knots at integers."""
    t = np.abs(t)
    beyond = np.maximum(2 - t, 0)
    return np.where(t < 1, 2 / 3 - t * t + t * t * t / 2, beyond * beyond * beyond / 6)


def _cubic_slope(t: Floats) -> Floats:
    size = np.abs(t)
    return np.sign(t) * np.where(size < 1, -2 * size + 1.5 * size**2, -0.5 * np.maximum(2 - size, 0) ** 2)


def _cubic_bend(t: Floats) -> Floats:
    t = np.abs(t)
    return np.where(t < 1, -2 + 3 * t, np.maximum(2 - t, 0))
