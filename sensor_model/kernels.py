"""Hot loops of the sensor: beams against bodies and walls, and the counter-based random numbers.

Plain arrays in and out. Beams come in rows of even azimuth steps (`beams.BeamTable`), so that a thing is tested only
against the beams that point at it: its azimuth interval, seen from a unit, is a range of indices in each of its rows.
"""

import math

import numpy as np
import numpy.typing as npt
from numba import njit

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]

NOTHING = -1
GROUND = -2
WALL = -3

_SLACK = 1e-9  # of a step: rounding must not lose the beam that just grazes a thing
_MASK = np.uint64(0xFFFFFFFF)
_HALF = np.uint64(32)
_ONE_32 = 2.0**-32
_PHILOX_ROUNDS = 10
_PHILOX_M0, _PHILOX_M1 = np.uint64(0xD2511F53), np.uint64(0xCD9E8D57)
_PHILOX_W0, _PHILOX_W1 = np.uint64(0x9E3779B9), np.uint64(0xBB67AE85)


@njit(cache=True)
def cast_bodies(
    pose: Floats, bounds: Floats, body_solid: Ints, solid_plane: Ints, planes: Floats,
    origin: Floats, rotation: Floats, unit_row: Ints, row_beam: Ints, row_azimuth: Floats, direction: Floats,
    range_min: Floats, open_range: Floats,
    nearest: Floats, target: Ints, surface: Ints, cosine: Floats, point_body: Floats, alone: Ints,
) -> None:  # fmt: skip
    """Cast every beam against every body, keeping the nearest hit.

    Parameters
    ----------
    pose, bounds, body_solid, solid_plane, planes
        As in `bodies.Bodies`.
    origin, rotation, unit_row, row_beam, row_azimuth, direction, range_min
        As in `beams.BeamTable`.
    open_range
        (B,) where a beam ends when no body and no wall is in its way [m].
    nearest, target, surface, cosine
        (B,) in and out: range so far [m], body and plane hit there, cosine of the angle of incidence.
    point_body
        (B, 2) out where a body is hit: the point there, in the body's frame [m].
    alone
        (A,) in and out: number of beams that would end on the body if it were alone on the ground.
    """
    x, y, gap = np.empty(8), np.empty(8), np.empty(len(planes))
    order, facing = np.empty(len(planes), np.int64), np.empty(len(solid_plane), np.int64)
    for a in range(len(pose)):
        cos, sin = math.cos(pose[a, 2]), math.sin(pose[a, 2])
        first, last = body_solid[a], body_solid[a + 1]
        for u in range(len(origin)):
            east, north = origin[u, 0] - pose[a, 0], origin[u, 1] - pose[a, 1]
            ox, oy, oz = cos * east + sin * north, cos * north - sin * east, origin[u, 2]
            _box_corners(bounds[a], ox, oy, oz, cos, sin, rotation[u], x, y)
            low, high = _azimuth_interval(x, y)
            _sort_planes(solid_plane, first, last, planes, ox, oy, oz, order, facing, gap)
            for r in range(unit_row[u], unit_row[u + 1]):
                for turn in range(-1, 2):
                    begin, end = _beams_between(row_beam[r], row_beam[r + 1], row_azimuth[r], low, high, turn)
                    for b in range(begin, end):
                        dx = cos * direction[b, 0] + sin * direction[b, 1]
                        dy = cos * direction[b, 1] - sin * direction[b, 0]
                        dz = direction[b, 2]
                        limit = _leaves_box(bounds[a], ox, oy, oz, dx, dy, dz, open_range[b])
                        if limit < 0.0:
                            continue
                        t, q = _enter_solids(solid_plane, first, last, planes, order, facing, gap, dx, dy, dz, limit)
                        if q >= 0 and t >= range_min[b]:
                            alone[a] += 1
                        if q >= 0 and t < nearest[b]:
                            nearest[b], target[b], surface[b] = t, a, q
                            cosine[b] = -(planes[q, 0] * dx + planes[q, 1] * dy + planes[q, 2] * dz)
                            point_body[b, 0], point_body[b, 1] = ox + t * dx, oy + t * dy


@njit(cache=True)
def cast_walls(
    ends: Floats, height: Floats, reach: float,
    origin: Floats, rotation: Floats, unit_row: Ints, row_beam: Ints, row_azimuth: Floats, direction: Floats,
    nearest: Floats, target: Ints, surface: Ints, cosine: Floats,
) -> None:  # fmt: skip
    """Cast every beam against every wall, keeping the nearest hit.

    Parameters
    ----------
    ends, height
        As in `walls.Walls`, in the ego frame.
    reach
        No unit sees farther than this from the ego frame's origin [m].
    origin, rotation, unit_row, row_beam, row_azimuth, direction
        As in `beams.BeamTable`.
    nearest, target, surface, cosine
        (B,) in and out: range so far [m], `WALL` and the wall hit there, cosine of the angle of incidence.
    """
    x, y = np.empty(4), np.empty(4)
    for w in range(len(ends)):
        px, py, ex, ey = ends[w, 0], ends[w, 1], ends[w, 2] - ends[w, 0], ends[w, 3] - ends[w, 1]
        length = math.hypot(ex, ey)
        if _distance_to_origin(px, py, ex, ey) > reach:
            continue
        for u in range(len(origin)):
            gx, gy, oz = px - origin[u, 0], py - origin[u, 1], origin[u, 2]
            _wall_corners(gx, gy, ex, ey, oz, height[w], rotation[u], x, y)
            low, high = _azimuth_interval(x, y)
            for r in range(unit_row[u], unit_row[u + 1]):
                for turn in range(-1, 2):
                    begin, end = _beams_between(row_beam[r], row_beam[r + 1], row_azimuth[r], low, high, turn)
                    for b in range(begin, end):
                        dx, dy, dz = direction[b, 0], direction[b, 1], direction[b, 2]
                        across = dx * ey - dy * ex
                        if across == 0.0:
                            continue
                        t = (gx * ey - gy * ex) / across
                        along = (gx * dy - gy * dx) / across
                        z = oz + t * dz
                        if 0.0 < t < nearest[b] and 0.0 <= along <= 1.0 and 0.0 <= z <= height[w]:
                            nearest[b], target[b], surface[b] = t, WALL, w
                            cosine[b] = abs(across) / length


@njit(cache=True)
def uniform_pairs(
    key: npt.NDArray[np.uint32], frame: int, unit: npt.NDArray[np.uint8], index: npt.NDArray[np.int32], purpose: int
) -> Floats:
    """Two independent numbers in (0, 1) for each of N beams, from the counter (frame, unit, index, purpose).

    Parameters
    ----------
    key
        (2,) uint32.
    frame, purpose
        Non-negative.
    unit, index
        (N,) a beam's unit and its index there.

    Returns
    -------
    (2, N)
    """
    pairs = np.empty((2, len(unit)))
    for i in range(len(unit)):
        words = philox(frame, unit[i], index[i], purpose, key[0], key[1])
        pairs[0, i] = (float(words[0]) + 0.5) * _ONE_32
        pairs[1, i] = (float(words[1]) + 0.5) * _ONE_32
    return pairs


@njit(cache=True)
def philox(c0: int, c1: int, c2: int, c3: int, k0: int, k1: int) -> tuple[np.uint64, np.uint64, np.uint64, np.uint64]:
    """Four random 32-bit words of Philox4x32-10 (Salmon et al., SC 2011) for counter c and key k, all below 2^32."""
    w0, w1, w2, w3 = np.uint64(c0), np.uint64(c1), np.uint64(c2), np.uint64(c3)
    key0, key1 = np.uint64(k0), np.uint64(k1)
    for _ in range(_PHILOX_ROUNDS):
        p0, p1 = _PHILOX_M0 * w0, _PHILOX_M1 * w2
        w0, w1, w2, w3 = (p1 >> _HALF) ^ w1 ^ key0, p1 & _MASK, (p0 >> _HALF) ^ w3 ^ key1, p0 & _MASK
        key0, key1 = (key0 + _PHILOX_W0) & _MASK, (key1 + _PHILOX_W1) & _MASK
    return w0, w1, w2, w3


@njit(cache=True)
def _box_corners(
    bounds: Floats, ox: float, oy: float, oz: float, cos: float, sin: float, rotation: Floats, x: Floats, y: Floats
) -> None:
    """Fill x and y (8,) with a body's corners in a unit's frame; (ox, oy, oz) is the unit in the body's frame."""
    for i in range(8):
        bx, by, bz = bounds[i & 1, 0] - ox, bounds[(i >> 1) & 1, 1] - oy, bounds[(i >> 2) & 1, 2] - oz
        ex, ey = cos * bx - sin * by, sin * bx + cos * by
        x[i] = rotation[0, 0] * ex + rotation[1, 0] * ey + rotation[2, 0] * bz
        y[i] = rotation[0, 1] * ex + rotation[1, 1] * ey + rotation[2, 1] * bz


@njit(cache=True)
def _wall_corners(
    gx: float, gy: float, ex: float, ey: float, oz: float, height: float, rotation: Floats, x: Floats, y: Floats
) -> None:
    """Fill x and y (4,) with a wall's corners in a unit's frame; (gx, gy) is its first end relative to the unit."""
    for i in range(4):
        wx, wy, wz = gx + (i & 1) * ex, gy + (i & 1) * ey, (i >> 1) * height - oz
        x[i] = rotation[0, 0] * wx + rotation[1, 0] * wy + rotation[2, 0] * wz
        y[i] = rotation[0, 1] * wx + rotation[1, 1] * wy + rotation[2, 1] * wz


@njit(cache=True)
def _azimuth_interval(x: Floats, y: Floats) -> tuple[float, float]:
    """Azimuths of the convex hull of points seen from the origin: low, high; infinite if it is around the origin."""
    cx, cy = x.mean(), y.mean()
    low, high = 0.0, 0.0
    for i in range(len(x)):
        turned = math.atan2(cx * y[i] - cy * x[i], cx * x[i] + cy * y[i])
        low, high = min(low, turned), max(high, turned)
    if high - low >= math.pi or (cx == 0.0 and cy == 0.0):
        return -math.inf, math.inf
    centre = math.atan2(cy, cx)
    return centre + low, centre + high


@njit(cache=True)
def _beams_between(first: int, end: int, azimuth: Floats, low: float, high: float, turn: int) -> tuple[int, int]:
    """Beams [begin, end) of a row [first, end) whose azimuth is between low and high, `turn` full turns away.

    `azimuth` (2,) is the row's first one and its step, which is negative.
    """
    if math.isinf(high):
        return (first, end) if turn == 0 else (first, first)
    shift = 2.0 * math.pi * turn - azimuth[0]
    begin = max(0.0, math.ceil((high + shift) / azimuth[1] - _SLACK))
    stop = min(end - first - 1.0, math.floor((low + shift) / azimuth[1] + _SLACK))
    return first + int(begin), first + int(stop) + 1


@njit(cache=True)
def _leaves_box(
    bounds: Floats, ox: float, oy: float, oz: float, dx: float, dy: float, dz: float, limit: float
) -> float:
    """Range at which a ray leaves a box, at most `limit`; -1 if it misses the box or meets it beyond `limit`."""
    enter, leave = 0.0, limit
    for axis in range(3):
        o = ox if axis == 0 else (oy if axis == 1 else oz)
        d = dx if axis == 0 else (dy if axis == 1 else dz)
        low, high = bounds[0, axis] - o, bounds[1, axis] - o
        if d == 0.0:
            if low > 0.0 or high < 0.0:
                return -1.0
        else:
            enter = max(enter, (low if d > 0.0 else high) / d)
            leave = min(leave, (high if d > 0.0 else low) / d)
    return leave if enter <= leave else -1.0


@njit(cache=True)
def _sort_planes(
    solid_plane: Ints, first: int, last: int, planes: Floats, ox: float, oy: float, oz: float,
    order: Ints, facing: Ints, gap: Floats,
) -> None:  # fmt: skip
    """Fill, for solids [first, last), the order of their planes, those that face the origin of the rays first.

    facing[p] is where the planes that face it end, gap[q] the signed distance of the origin inward of plane q.
    """
    for p in range(first, last):
        front, back = solid_plane[p], solid_plane[p + 1]
        for q in range(solid_plane[p], solid_plane[p + 1]):
            gap[q] = planes[q, 3] - planes[q, 0] * ox - planes[q, 1] * oy - planes[q, 2] * oz
            if gap[q] < 0.0:
                order[front] = q
                front += 1
            else:
                back -= 1
                order[back] = q
        facing[p] = front


@njit(cache=True)
def _enter_solids(
    solid_plane: Ints, first: int, last: int, planes: Floats, order: Ints, facing: Ints, gap: Floats,
    dx: float, dy: float, dz: float, limit: float,
) -> tuple[float, int]:  # fmt: skip
    """Nearest entry of a ray into solids [first, last): range and plane, which is -1 if there is none before `limit`.

    A ray enters a solid through the last of the planes that face its origin, unless it has left by then.
    """
    nearest, hit = limit, -1
    for p in range(first, last):
        enter, entered = 0.0, -1
        for i in range(solid_plane[p], facing[p]):
            q = order[i]
            rate = planes[q, 0] * dx + planes[q, 1] * dy + planes[q, 2] * dz
            t = gap[q] / rate if rate < 0.0 else nearest
            if t > enter:
                enter, entered = t, q
            if enter >= nearest:
                break
        if entered < 0 or enter >= nearest:
            continue
        leave = nearest
        for i in range(facing[p], solid_plane[p + 1]):
            q = order[i]
            rate = planes[q, 0] * dx + planes[q, 1] * dy + planes[q, 2] * dz
            if rate > 0.0 and gap[q] <= enter * rate:
                leave = enter
                break
        if enter < leave:
            nearest, hit = enter, entered
    return nearest, hit


@njit(cache=True)
def _distance_to_origin(px: float, py: float, ex: float, ey: float) -> float:
    """Distance of the segment from (px, py) to (px + ex, py + ey) to the origin."""
    along = -(px * ex + py * ey) / (ex * ex + ey * ey)
    along = min(1.0, max(0.0, along))
    return math.hypot(px + along * ex, py + along * ey)
