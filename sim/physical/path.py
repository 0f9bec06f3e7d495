"""The way of points, known at an instant by place and derivatives."""

from dataclasses import dataclass

import numpy as np

from sim.world import Floats


@dataclass(frozen=True, slots=True, eq=False)
class Path:
    """Where N points ought to be at one instant, and how they ought to move."""

    place: Floats
    """(N, 2) [m]."""
    velocity: Floats
    """(N, 2) [m/s]."""
    acceleration: Floats
    """(N, 2) [m/s^2]."""

    def toward(self, other: "Path", share: float, dt: float) -> "Path":
        """Return a share of the way to the path `dt` [s] later: the cubic Hermite through both."""
        s = share
        place = (
            (1 + 2 * s) * (1 - s) ** 2 * self.place
            + s * (1 - s) ** 2 * dt * self.velocity
            + s**2 * (3 - 2 * s) * other.place
            + s**2 * (s - 1) * dt * other.velocity
        )
        velocity = (1 - s) * self.velocity + s * other.velocity
        return Path(place, velocity, (1 - s) * self.acceleration + s * other.acceleration)

    def shifted(self, time: Floats) -> "Path":
        """Return the path `time` (N,) [s] later, as its derivatives tell; earlier where it is negative."""
        t = time[:, None]
        return Path(
            self.place + t * self.velocity + 0.5 * t**2 * self.acceleration,
            self.velocity + t * self.acceleration,
            self.acceleration,
        )

    def lag_of(self, points: Floats, most: float) -> Floats:
        """Return by how much time (N,) [s] points (N, 2) are behind where they ought to be, within `most` [s]."""
        speed_squared = np.maximum(np.einsum("nc,nc->n", self.velocity, self.velocity), 1.0)
        return within(np.einsum("nc,nc->n", self.place - points, self.velocity) / speed_squared, most)

    def acceleration_across(self) -> Floats:
        """Return the size (N,) of the acceleration across the way [m/s^2]."""
        cross = self.velocity[:, 0] * self.acceleration[:, 1] - self.velocity[:, 1] * self.acceleration[:, 0]
        return np.abs(cross) / np.maximum(np.hypot(*self.velocity.T), 0.1)


def along_across(vector: Floats, yaw: Floats) -> tuple[Floats, Floats]:
    """Return the parts (N,) of vectors (N, 2) along yaws (N,) [rad] and to their left."""
    cos, sin = np.cos(yaw), np.sin(yaw)
    return vector[:, 0] * cos + vector[:, 1] * sin, vector[:, 1] * cos - vector[:, 0] * sin


def within(value: Floats, limit: Floats | float) -> Floats:
    """Return values (N,) cut to limits on both sides of zero."""
    cut: Floats = np.minimum(np.maximum(value, -limit), limit)
    return cut
