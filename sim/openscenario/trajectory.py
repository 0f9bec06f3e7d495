"""Motion along a polyline, at given times or at the speed of the entity."""

import math
from bisect import bisect_right
from itertools import accumulate, pairwise

from luxloop import elementary

STANDING_M = 1e-6
"""[m] Shorter steps do not define a course."""

Pose = tuple[float, float, float]


class Trajectory:
    """Way of an entity along a polyline, from now on.

    Parameters
    ----------
    vertices
        x [m], y [m] and heading [rad] of the vertices, two or more; without a heading, None, it is the course.
    times
        Times [s] of the vertices since the beginning of the action; None for the entity's own speed.
    skipped
        Length [m] of the polyline before the entity; unused with times.
    """

    def __init__(
        self,
        vertices: list[tuple[float, float, float | None]],
        times: tuple[float, ...] | None,
        skipped: float,
    ):
        self._vertices, self._times = vertices, times
        steps = [math.dist(a[:2], b[:2]) for a, b in pairwise(vertices)]
        self._lengths = [0.0, *accumulate(steps)]
        self._courses = _courses(vertices, steps)
        self._elapsed = 0.0
        self.travelled = skipped if times is None else self._length_now(times)

    @property
    def reverses(self) -> bool:
        """True if the entity drives backwards on a part of the polyline."""
        return any(map(self._is_backwards, range(len(self._courses))))

    @property
    def backwards(self) -> bool:
        """True if the entity drives backwards now."""
        return self._is_backwards(_segment(self._lengths, self.travelled))

    @property
    def timed(self) -> bool:
        """True if the trajectory has times, which determine the speed."""
        return self._times is not None

    @property
    def done(self) -> bool:
        """True at the end of the polyline."""
        if self._times is not None:
            return self._elapsed >= self._times[-1]
        return self.travelled >= self._lengths[-1]

    @property
    def speed(self) -> float:
        """Speed [m/s] by the times, also at the end of the polyline; 0 without times."""
        if self._times is None:
            return 0.0
        n = _segment(self._times, self._elapsed)
        return (self._lengths[n + 1] - self._lengths[n]) / (self._times[n + 1] - self._times[n])

    @property
    def pose(self) -> Pose:
        """Position x [m], y [m] and yaw [rad] of the reference point."""
        n = _segment(self._lengths, self.travelled)
        (x, y, begin), (end_x, end_y, end) = self._vertices[n : n + 2]
        length = self._lengths[n + 1] - self._lengths[n]
        part = min(max((self.travelled - self._lengths[n]) / length, 0.0), 1.0) if length else 1.0
        course = self._courses[n]
        yaw = course
        if begin is not None and end is not None:
            yaw = begin + part * math.remainder(end - begin, 2 * math.pi)
        return x + part * (end_x - x), y + part * (end_y - y), yaw

    def advance(self, step: float, distance: float) -> float:
        """Advance by a time [s], or by a distance [m] without times; return the distance."""
        before = self.travelled
        self._elapsed = round(self._elapsed + step, 9)
        if self._times is not None:
            self.travelled = self._length_now(self._times)
        else:
            self.travelled = min(before + distance, self._lengths[-1])
        return self.travelled - before

    def _is_backwards(self, segment: int) -> bool:
        heading = self._vertices[segment][2]
        return heading is not None and elementary.cos(heading - self._courses[segment]) < 0

    def _length_now(self, times: tuple[float, ...]) -> float:
        n = _segment(times, self._elapsed)
        part = min(max((self._elapsed - times[n]) / (times[n + 1] - times[n]), 0.0), 1.0)
        return self._lengths[n] + part * (self._lengths[n + 1] - self._lengths[n])


def _courses(vertices: list[tuple[float, float, float | None]], steps: list[float]) -> list[float]:
    """Return the direction [rad] of each step; a step on the spot has that before it, or else that after it."""
    found = [
        elementary.atan2(b[1] - a[1], b[0] - a[0]) if step > STANDING_M else None
        for (a, b), step in zip(pairwise(vertices), steps, strict=True)
    ]
    first = next((course for course in found if course is not None), 0.0)
    return list(accumulate(found, lambda before, course: before if course is None else course, initial=first))[1:]


def _segment(values: list[float] | tuple[float, ...], value: float) -> int:
    """Return the number of the interval of rising values that contains a value, the nearest one beyond the ends."""
    return min(max(bisect_right(values, value) - 1, 0), len(values) - 2)
