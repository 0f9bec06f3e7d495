"""The way of points: place and derivatives at an instant, and the last seconds of them."""

from dataclasses import dataclass

import numpy as np

from sim.world import Floats, Ints


@dataclass(frozen=True, slots=True, eq=False)
class Path:
    """Where N points ought to be at one instant each, and how they ought to move."""

    place: Floats
    """(N, 2) [m]."""
    velocity: Floats
    """(N, 2) [m/s]."""
    acceleration: Floats
    """(N, 2) [m/s^2]."""

    def shifted(self, time: Floats) -> "Path":
        """Return the path `time` (N,) [s] later, as its derivatives tell; earlier where it is negative."""
        t = time[:, None]
        return Path(
            self.place + t * self.velocity + 0.5 * t**2 * self.acceleration,
            self.velocity + t * self.acceleration,
            self.acceleration,
        )

    def acceleration_across(self) -> Floats:
        """Return the size (N,) of the acceleration across the way [m/s^2]."""
        cross = self.velocity[:, 0] * self.acceleration[:, 1] - self.velocity[:, 1] * self.acceleration[:, 0]
        across: Floats = np.abs(cross) / np.maximum(np.hypot(*self.velocity.T), 0.1)
        return across


class Trail:
    """Paths of the last frames, by the number of the body.

    Parameters
    ----------
    dt
        Time between frames [s].
    seconds
        How long they are kept [s].
    """

    def __init__(self, dt: float, seconds: float):
        self._dt = dt
        self._length = max(round(seconds / dt), 2)
        self._latest = -1
        self._since: Ints = np.zeros(0, np.int64)
        self._known: Floats = np.zeros((self._length, 0, 3, 2))

    def add(self, id: Ints, come: Ints, path: Path) -> None:
        """Add a frame: bodies `id` (N,) ascending, `come` (M,) those of them who were not in the last one."""
        self._latest += 1
        if id[-1] >= len(self._since):
            room = (0, 2 * int(id[-1]) + 64 - len(self._since))
            self._since = np.pad(self._since, room)
            self._known = np.pad(self._known, ((0, 0), room, (0, 0), (0, 0)))
        self._since[come] = self._latest
        self._known[self._latest % self._length, id] = np.stack([path.place, path.velocity, path.acceleration], axis=1)

    def at(self, id: Ints, ago: Floats) -> Path:
        """Return the paths of bodies (N,) `ago` (N,) [s] before the latest frame: cubic between frames.

        Before the first and after the last one that is known, the derivatives tell.
        """
        wanted = self._latest - ago / self._dt
        first = np.maximum(self._since[id], self._latest - self._length + 1)
        before = np.clip(np.floor(wanted), first, np.maximum(self._latest - 1, first)).astype(np.int64)
        share = np.clip(wanted - before, 0.0, np.minimum(self._latest - before, 1.0))
        start = self._known[before % self._length, id]
        end = self._known[(before + 1) % self._length, id]
        s, h = share[:, None], self._dt
        place = (
            (1 + 2 * s) * (1 - s) ** 2 * start[:, 0]
            + s * (1 - s) ** 2 * h * start[:, 1]
            + s**2 * (3 - 2 * s) * end[:, 0]
            + s**2 * (s - 1) * h * end[:, 1]
        )
        known = Path(place, *(start[:, d] + s * (end[:, d] - start[:, d]) for d in (1, 2)))
        return known.shifted((wanted - before - share) * h)


def along_across(vector: Floats, yaw: Floats) -> tuple[Floats, Floats]:
    """Return the parts (N,) of vectors (N, 2) along yaws (N,) [rad] and to their left."""
    cos, sin = np.cos(yaw), np.sin(yaw)
    return vector[:, 0] * cos + vector[:, 1] * sin, vector[:, 1] * cos - vector[:, 0] * sin


def within(value: Floats, limit: Floats | float) -> Floats:
    """Return values (N,) cut to limits on both sides of zero."""
    cut: Floats = np.minimum(np.maximum(value, -limit), limit)
    return cut
