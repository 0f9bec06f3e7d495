"""Trams and trains: the ends of their sections are on the path that the front has driven, as bogies follow the rails.

The rates follow from the constant length of the sections. For the ends p and q of a section of length L, front end
first, with e from q to p: e . (q' - p') = 0, and e . (q'' - p'') = |q' - p'|^2 / L; q' and the part of q'' across the
path are given by the path's direction and curvature.
"""

import math

import numpy as np

from luxloop import elementary, elementwise
from luxloop.arrays import Floats
from luxloop.sim.kinematics import wrap_angle
from luxloop.sim.physical.limits import STANDING
from luxloop.sim.roster import Member
from luxloop.sim.sections import sections
from luxloop.sim.world import JOINTS

STEP_M = 0.3
"""[m] Distance between stored points of a path."""
_CURVATURE_M = 0.6
"""[m] Length along the path to each side over which its curvature is averaged."""
_SHARPEST = 1.0 / 15.0
"""[1/m] Largest curvature assumed for the unknown path behind a new body; tracks of trams have radii above 15 m."""
_MARGIN = 1.2
"""Length of the stored path, as a multiple of the body's: a bent body spans more of it than its length."""

Motion = tuple[Floats, Floats, Floats]
"""Position (2,) [m], velocity (2,) [m/s] and acceleration (2,) [m/s^2] of a point."""


class SectionChain:
    """Sections of one tram or train and the path that its front has driven.

    Parameters
    ----------
    member
        The tram or train.
    front
        (7,) motion of the front: position, yaw, velocity and acceleration.
    yaw
        Yaw of the line from its rear to its front [rad], in the simulator. With the course of the front it defines the
        arc on which a new body stands.
    """

    def __init__(self, member: Member, front: Floats, yaw: float):
        kind, length = np.array([member.kind], np.uint8), np.array([member.size[0]])
        (self._middle,), _, (starts,), (ends,) = sections(kind, length)
        self._length = member.size[0]
        self._starts, self._lengths = starts, (ends - starts)[ends > starts]
        course = elementary.atan2(front[4], front[3]) if elementary.hypot(front[3], front[4]) > STANDING else yaw
        turn = float(wrap_angle(np.array([course - yaw]))[0])
        curvature = float(np.clip(2.0 * elementary.sin(turn) / self._length, -_SHARPEST, _SHARPEST))
        behind = np.arange(0.0, _MARGIN * self._length + 2 * STEP_M, STEP_M)[::-1]
        self._course = course - curvature * behind
        middle = course - 0.5 * curvature * behind  # direction of the chord to the front
        chord = behind * np.sinc(0.5 * curvature * behind / math.pi)
        self._place = front[:2] - chord[:, None] * np.column_stack([elementwise.cos(middle), elementwise.sin(middle)])

    def follow(self, front: Floats) -> tuple[Floats, Floats]:
        """Return the motion of the box (8,), as in `frame_motions`, and the angles (JOINTS,) at the joints [rad].

        Parameters
        ----------
        front
            (8,) motion of the front in the next frame.
        """
        place, course = self._with_head(front)
        along = np.concatenate([[0.0], np.cumsum(elementwise.hypot(*np.diff(place, axis=0).T))])
        point: Motion = front[:2], front[3:5], front[5:7]
        yaw, at = np.empty(len(self._lengths)), float(along[-1])
        box = np.empty(8)
        for section, length in enumerate(self._lengths):
            before = point
            at, rear = _point_behind(place, along, at, before[0], float(length))
            line = (before[0] - rear) / length
            point = (rear, *_rates_behind(before, line, float(length), along, course, at))
            yaw[section] = elementary.atan2(line[1], line[0])
            if section == self._middle:
                ahead = float(self._starts[section]) - 0.5 * self._length
                box = _box_motion(before, point, line, float(length), ahead)
        angles = np.zeros(JOINTS)
        angles[: len(yaw) - 1] = wrap_angle(yaw[:-1] - yaw[1:])
        return box, angles

    def _with_head(self, front: Floats) -> tuple[Floats, Floats]:
        """Return points (M, 2) [m] and courses (M,) [rad] of the path up to the front; store it if it moved on."""
        while len(self._place) > 2 and _ahead(front[:2] - self._place[-1], self._course[-1]) < 0.0:
            self._place, self._course = self._place[:-1], self._course[:-1]
        course = self._course[-1]
        if elementary.hypot(front[3], front[4]) > STANDING:
            course += float(wrap_angle(np.array([elementary.atan2(front[4], front[3]) - course]))[0])
        step = math.dist(front[:2], self._place[-1])
        share = np.arange(1, max(int(step / STEP_M), 1) + 1) / max(int(step / STEP_M), 1)
        between = _cubic(self._place[-1], front[:2], self._course[-1], course, share)
        path = (
            np.vstack([self._place, between]),
            np.append(self._course, self._course[-1] + share * (course - self._course[-1])),
        )
        if step >= STEP_M:
            keep = math.ceil((_MARGIN * self._length) / STEP_M) + 2
            self._place, self._course = path[0][-keep:], path[1][-keep:]
        return path


def _cubic(start: Floats, end: Floats, start_course: float, end_course: float, share: Floats) -> Floats:
    """Return points (K, 2) on the Hermite cubic between two points with courses [rad], at shares (K,) of it."""
    u = share[:, None]
    reach = math.dist(start, end)
    leave, arrive = (reach * np.array([elementary.cos(a), elementary.sin(a)]) for a in (start_course, end_course))
    smooth = u * u * (3.0 - 2.0 * u)
    points: Floats = start + smooth * (end - start) + u * (1.0 - u) * ((1.0 - u) * leave - u * arrive)
    return points


def _ahead(offset: Floats, course: float) -> float:
    return float(offset[0] * elementary.cos(course) + offset[1] * elementary.sin(course))


def _dot(one: Floats, other: Floats) -> float:
    return float(one[0] * other[0] + one[1] * other[1])


def _point_behind(place: Floats, along: Floats, at: float, front: Floats, distance: float) -> tuple[float, Floats]:
    """Return the last point of a path before `at` [m] in a straight distance from a front: where along it, and x, y."""
    behind = place[: int(np.searchsorted(along, at))]
    far = np.flatnonzero(elementwise.hypot(*(behind - front).T) >= distance)
    begin = int(far[-1]) if len(far) else 0
    step, offset = place[begin + 1] - place[begin], place[begin] - front
    square, half = _dot(step, step), _dot(step, offset)
    share = (-half - math.sqrt(max(half**2 - square * (_dot(offset, offset) - distance**2), 0.0))) / square
    return float(along[begin] + share * math.sqrt(square)), place[begin] + share * step


def _rates_behind(
    ahead: Motion, line: Floats, length: float, along: Floats, course: Floats, at: float
) -> tuple[Floats, Floats]:
    """Return velocity and acceleration (2,) of the rear end of a section, from the motion of its front end."""
    low, high = np.interp([at - _CURVATURE_M, at + _CURVATURE_M], along, course)
    direction = float(np.interp(at, along, course))
    curvature = (high - low) / (2 * _CURVATURE_M)
    tangent = np.array([elementary.cos(direction), elementary.sin(direction)])
    normal = np.array([-tangent[1], tangent[0]])
    cosine = _dot(tangent, line)
    speed = _dot(ahead[1], line) / cosine
    turning = curvature * speed**2 * normal
    difference = ahead[1] - speed * tangent
    needed = _dot(ahead[2], line) + _dot(difference, difference) / length
    return speed * tangent, (needed - _dot(turning, line)) / cosine * tangent + turning


def _box_motion(front: Motion, rear: Motion, line: Floats, length: float, ahead: float) -> Floats:
    """Return the motion (8,) of a point `ahead` [m] of the front end of a section, on its axis."""
    across = np.array([-line[1], line[0]])
    rate = _dot(front[1] - rear[1], across) / length
    turning = _dot(front[2] - rear[2], across) / length
    place = front[0] + ahead * line
    velocity = front[1] + ahead * rate * across
    acceleration = front[2] + ahead * (turning * across - rate**2 * line)
    return np.array([*place, elementary.atan2(line[1], line[0]), *velocity, *acceleration, rate])
