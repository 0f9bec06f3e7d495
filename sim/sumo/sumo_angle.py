"""Conversion of SUMO's angles to yaw."""

import math


def yaw_of(angle: float) -> float:
    """Return the yaw in (-pi, pi] [rad], counter-clockwise from east, of an angle in degrees clockwise from north."""
    return math.pi - math.radians(90.0 + angle) % math.tau
