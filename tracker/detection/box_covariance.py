"""Covariance of the corner and the heading of boxes."""

import math

import numpy as np

from luxloop.tracker.arrays import Floats, Ints
from luxloop.tracker.geometry import QUARTER, rotate

HEADING_PRIOR_STD = QUARTER / math.sqrt(12.0)
"""Standard deviation of a heading with a uniform distribution over a quarter turn, the prior without points [rad]."""


def side_covariance(from_corner: Floats, box: Ints, heading: Floats, noise_std_m: float, end_std_m: float) -> Floats:
    """(B, 3, 3) covariance of corner x, y [m] and heading [rad], ego frame, by least squares on both sides.

    In the box's frame, with its origin at the corner: when the box moves by (dx, dy) and turns about the corner, the
    residual of a point at (u, 0) on one side changes by dy + u * dheading, that of a point at (0, v) on the other side
    by dx - v * dheading. The sum of the outer products of these rows over the noise, plus the prior, is the information
    matrix. Points scatter about a side by `noise_std_m`; an end without points has `end_std_m`.
    """
    u, v = rotate(from_corner, -heading[box]).T
    lies_along, one, none = np.abs(v) <= np.abs(u), np.ones_like(u), np.zeros_like(u)
    row = np.where(lies_along, [none, one, u], [one, none, -v]).T / noise_std_m
    products = (row[:, :, None] * row[:, None, :]).reshape(-1, 9)
    sums = np.stack([np.bincount(box, product, len(heading)) for product in products.T], axis=1)
    prior = np.diag([end_std_m**-2, end_std_m**-2, HEADING_PRIOR_STD**-2])
    information = prior + sums.reshape(-1, 3, 3)
    turn = np.zeros_like(information)
    turn[:, 0, 0] = turn[:, 1, 1] = np.cos(heading)
    turn[:, 1, 0], turn[:, 0, 1], turn[:, 2, 2] = np.sin(heading), -np.sin(heading), 1.0
    return np.asarray(turn @ np.linalg.inv(information) @ turn.transpose(0, 2, 1))


def corner_covariance(covariance: Floats, from_mean: Floats, end_std_m: float) -> Floats:
    """(B, 3, 3) covariance of corner x, y [m] and heading [rad], ego frame, from that of fitted bodies.

    A corner at `from_mean` (B, 2) from the mean of the points moves when the body turns about the mean. The end of a
    side without points on the adjacent side has the prior `end_std_m`.
    """
    moved = np.zeros_like(covariance)
    moved[:, 0, 0] = moved[:, 1, 1] = moved[:, 2, 2] = 1.0
    moved[:, 0, 2], moved[:, 1, 2] = -from_mean[:, 1], from_mean[:, 0]
    of_corner = moved @ covariance @ moved.transpose(0, 2, 1)
    prior = np.diag([end_std_m**-2, end_std_m**-2, HEADING_PRIOR_STD**-2])
    return np.asarray(np.linalg.inv(np.linalg.inv(of_corner) + prior))
