"""Rays against the bodies: each is a few convex solids n . p <= d.

A ray of slope s from o along f + s u meets a plane at the nearness (n . f + s n . u) / (d - n . o), which is linear in
s. It enters a solid at the least nearness of the planes that o is outside of, and has not left it by then if that is
more than the nearness of each plane that o is inside of. So no ray needs a division.
"""

import math

import numpy as np
from numba import njit

from sensor_model.arrays import Bools, Floats, Ints
from sensor_model.kernels.motion import body_at
from sensor_model.kernels.rays import NONE, even_turns
from sensor_model.kernels.records import Rays, Solids

_ON_PLANE = 1e-300  # just inside: rays that go out do so at once, and none is divided by zero
_SLACK = 1e-9  # rounding must not lose a ray that just grazes a thing


@njit(cache=True, error_model="numpy")
def meet_bodies(rows: Ints, turns: int, time: Floats, rays: Rays, bodies: Solids, hits_alone: Ints) -> None:
    """Shorten the rays that meet bodies, and look behind panes.

    Parameters
    ----------
    rows
        (K, 3) body, first azimuth, and end.
    hits_alone
        (A,) in and out: rays that would end on each body, were it alone on the ground.
    """
    # Out of their records once: each time costs an atomic reference count. So do calls, hence what is inlined below.
    column, slope, cos, far, nearness, target, surface, cosine, inner_surface, inner_nearness, inner_cosine = rays
    body_solid, solid_plane, solid_bounds = bodies.body_solid, bodies.solid_plane, bodies.solid_bounds
    motion, solid_inner, planes, transmission = bodies.motion, bodies.solid_inner, bodies.planes, bodies.transmission
    columns, n = slope.shape
    seen, reach, extremes = np.empty((9, columns)), np.empty((6, columns)), _extremes(slope)
    span, most = np.empty((2, len(solid_inner)), np.int64), _most(solid_plane) + 3
    into, out, plane_in = np.empty((2, most)), np.empty((2, most)), np.empty(most, np.int64)
    own, own_plane = np.empty((3, n)), np.empty((2, n), np.int64)
    for row in range(len(rows)):
        a, first, end = rows[row, 0], rows[row, 1] * turns, rows[row, 2] * turns
        into_body(column, rows[row, 1], rows[row, 2], turns, time, motion, a, seen)
        _reach(seen, extremes, first, end - first, reach)
        for p in range(body_solid[a], body_solid[a + 1]):
            span[0, p], span[1, p] = _columns_at(solid_bounds, p, seen, end - first, reach)
        for c in range(end - first):
            m = first + c
            if not _enter_solids(
                False, body_solid[a], body_solid[a + 1], solid_inner, span, solid_plane, planes, seen, c,
                column, slope, far, m, into, plane_in, out, own, own_plane,
            ):  # fmt: skip
                continue
            alone, panes = _keep_nearer(
                a, planes, transmission, seen, c, m, own, own_plane, cos,
                nearness, target, surface, cosine, inner_surface,
            )  # fmt: skip
            hits_alone[a] += alone
            if panes and _enter_solids(
                True, body_solid[a], body_solid[a + 1], solid_inner, span, solid_plane, planes, seen, c,
                column, slope, far, m, into, plane_in, out, own, own_plane,
            ):  # fmt: skip
                _look_inside(
                    a, planes, transmission, seen, c, m, own, own_plane, cos, target, surface,
                    inner_surface, inner_nearness, inner_cosine,
                )  # fmt: skip


@njit(cache=True, error_model="numpy", inline="always")
def _enter_solids(
    inner: bool, begin: int, stop: int, solid_inner: Bools, span: Ints, solid_plane: Ints, planes: Floats, seen: Floats,
    c: int, column: Floats, slope: Floats, far: Floats, m: int, into: Floats, plane_in: Ints, out: Floats,
    own: Floats, own_plane: Ints,
) -> bool:  # fmt: skip
    """Let the rays of column m enter the inner or the outer solids among [begin, stop); return whether any may have.

    Parameters
    ----------
    span
        (2, P) first column and end of those that may meet each solid; this one is c there, and in `seen`.
    own, own_plane
        (3, n), (2, n) out, the first of each: nearness and plane where the rays end, alone with the body on the ground.
        The others and `into`, `plane_in` and `out` are there to work in.
    """
    _open(column, slope, far, m, own, own_plane)
    met = False
    for p in range(begin, stop):
        if span[0, p] <= c < span[1, p] and solid_inner[p] == inner:
            facing, hidden = _split(planes, solid_plane[p], solid_plane[p + 1], seen, c, into, plane_in, out)
            if facing > 0:
                _enter(into, plane_in, facing, out, hidden, slope, m, own, own_plane)
                met = True
    return met


@njit(cache=True)
def _most(offsets: Ints) -> int:
    """How many members the largest group has."""
    most = 0
    for g in range(len(offsets) - 1):
        most = max(most, offsets[g + 1] - offsets[g])
    return most


@njit(cache=True)
def _extremes(slope: Floats) -> Floats:
    """(2, M) slopes of the lowest and of the highest ray of each column."""
    extremes = np.empty((2, len(slope)))
    for m in range(len(slope)):
        low, high = slope[m, 0], slope[m, 0]
        for i in range(slope.shape[1]):
            low, high = min(low, slope[m, i]), max(high, slope[m, i])
        extremes[0, m], extremes[1, m] = low, high
    return extremes


@njit(cache=True, inline="always")
def into_body(
    column: Floats, begin: int, stop: int, turns: int, time: Floats, motion: Floats, a: int, seen: Floats
) -> None:
    """Fill `seen` (9, C) with the columns of azimuths [begin, stop) in the frame of body a at their time."""
    rate = motion[a, 7]
    cos, sin, step_cos, step_sin = even_turns(motion[a, 2] + rate * time[begin], rate, time)
    c = 0
    for k in range(begin, stop):
        x, y = body_at(motion, a, time[k])
        for m in range(k * turns, (k + 1) * turns):
            dx, dy = column[0, m] - x, column[1, m] - y
            seen[0, c], seen[1, c], seen[2, c] = cos * dx + sin * dy, cos * dy - sin * dx, column[2, m]
            for axis in (3, 6):
                seen[axis, c] = cos * column[axis, m] + sin * column[axis + 1, m]
                seen[axis + 1, c] = cos * column[axis + 1, m] - sin * column[axis, m]
                seen[axis + 2, c] = column[axis + 2, m]
            c += 1
        cos, sin = cos * step_cos - sin * step_sin, sin * step_cos + cos * step_sin


@njit(cache=True, error_model="numpy", inline="always")
def _reach(seen: Floats, extremes: Floats, first: int, columns: int, reach: Floats) -> None:
    """Fill (6, C): lowest and highest direction of each column in plan (x, y, x, y), and bounds of the climbs between.

    Climb is height over distance in plan. A ray between the lowest l and the highest h is a l + b h with a, b >= 0. It
    is steeper than both where they point apart in plan, by an angle v, for then |a l + b h| there is shorter than
    a |l| + b |h|: down to cos(v / 2) of it.
    """
    start = np.uint64(first)
    for c in range(np.uint64(columns)):
        down, up = extremes[0, start + c], extremes[1, start + c]
        lx, ly, lz = seen[3, c] + down * seen[6, c], seen[4, c] + down * seen[7, c], seen[5, c] + down * seen[8, c]
        hx, hy, hz = seen[3, c] + up * seen[6, c], seen[4, c] + up * seen[7, c], seen[5, c] + up * seen[8, c]
        one, other = 1.0 / math.sqrt(lx * lx + ly * ly), 1.0 / math.sqrt(hx * hx + hy * hy)
        lx, ly, lz, hx, hy, hz = one * lx, one * ly, one * lz, other * hx, other * hy, other * hz
        steeper = 1.0 / math.sqrt(0.5 * (1.0 + lx * hx + ly * hy) + 1e-12)
        fall, climb = min(lz, hz), max(lz, hz)
        reach[0, c], reach[1, c], reach[2, c], reach[3, c] = lx, ly, hx, hy
        reach[4, c] = min(fall, fall * steeper) - _SLACK
        reach[5, c] = max(climb, climb * steeper) + _SLACK


@njit(cache=True, error_model="numpy", inline="always")
def _columns_at(bounds: Floats, p: int, seen: Floats, columns: int, reach: Floats) -> tuple[int, int]:
    """Range of the columns that holds all with a ray that may meet the box around solid p."""
    length, width = 0.5 * (bounds[p, 1, 0] - bounds[p, 0, 0]), 0.5 * (bounds[p, 1, 1] - bounds[p, 0, 1])
    cx, cy = 0.5 * (bounds[p, 0, 0] + bounds[p, 1, 0]), 0.5 * (bounds[p, 0, 1] + bounds[p, 1, 1])
    radius = math.sqrt(length * length + width * width)
    bottom_z, top_z = bounds[p, 0, 2], bounds[p, 1, 2]
    left, right = columns, 0
    for c in range(columns):
        x, y = cx - seen[0, c], cy - seen[1, c]
        lx, ly, hx, hy = reach[0, c], reach[1, c], reach[2, c], reach[3, c]
        # How far the centre is to the left of a ray, against how far the box reaches across it.
        left_of_low, left_of_high = lx * y - ly * x, hx * y - hy * x
        across_low = abs(lx) * width + abs(ly) * length + _SLACK
        across_high = abs(hx) * width + abs(hy) * length + _SLACK
        distance = math.sqrt(x * x + y * y)
        near, far = max(0.0, distance - radius), distance + radius
        top = seen[2, c] + max(reach[5, c] * near, reach[5, c] * far)
        bottom = seen[2, c] + min(reach[4, c] * near, reach[4, c] * far)
        missed = (
            (left_of_low > across_low) & (left_of_high > across_high)
            | (left_of_low < -across_low) & (left_of_high < -across_high)
            | (lx * x + ly * y < -radius) & (hx * x + hy * y < -radius)
            | (top < bottom_z)
            | (bottom > top_z)
        )
        left = min(left, columns if missed else c)
        right = max(right, 0 if missed else c + 1)
    return left, right


@njit(cache=True, error_model="numpy", inline="always")
def _open(column: Floats, slope: Floats, far: Floats, m: int, own: Floats, own_plane: Ints) -> None:
    """Start column m alone with the ground: own[0] is the nearness at which each ray ends."""
    level, per_slope = -column[5, m] / column[2, m], -column[8, m] / column[2, m]
    for i in range(slope.shape[1]):
        own[0, i] = max(level + slope[m, i] * per_slope, far[m, i])
        own_plane[0, i] = NONE


@njit(cache=True, error_model="numpy", inline="always")
def _split(
    planes: Floats, begin: int, stop: int, seen: Floats, c: int, into: Floats, plane_in: Ints, out: Floats
) -> tuple[int, int]:
    """Fill nearness at slope 0 and per slope of the planes [begin, stop) that column c is outside and inside of.

    Returns
    -------
    How many of each; there are three more in the tables that no ray meets.
    """
    x, y, z = seen[0, c], seen[1, c], seen[2, c]
    facing, hidden = 0, 0
    for q in range(begin, stop):
        nx, ny, nz = planes[q, 0], planes[q, 1], planes[q, 2]
        inward = planes[q, 3] - nx * x - ny * y - nz * z
        inward = inward if inward != 0.0 else _ON_PLANE
        per_metre = 1.0 / inward
        level = (nx * seen[3, c] + ny * seen[4, c] + nz * seen[5, c]) * per_metre
        per_slope = (nx * seen[6, c] + ny * seen[7, c] + nz * seen[8, c]) * per_metre
        into[0, facing], into[1, facing], plane_in[facing] = level, per_slope, q
        out[0, hidden], out[1, hidden] = level, per_slope
        facing += inward < 0.0
        hidden += inward > 0.0
    for spare in range(3):
        into[0, facing + spare], into[1, facing + spare], plane_in[facing + spare] = math.inf, 0.0, NONE
        out[0, hidden + spare], out[1, hidden + spare] = -math.inf, 0.0
    return facing, hidden


@njit(cache=True, error_model="numpy", inline="always")
def _enter(
    into: Floats, plane_in: Ints, facing: int, out: Floats, hidden: int, slope: Floats, m: int,
    own: Floats, own_plane: Ints,
) -> None:  # fmt: skip
    """Shorten the rays of column m, own[0], that enter the solid before; four planes at a time stay in registers."""
    n = slope.shape[1]
    for i in range(n):
        own[1, i], own[2, i], own_plane[1, i] = math.inf, own[0, i], NONE
    for k in range(0, facing, 4):
        l0, l1, l2, l3 = into[0, k], into[0, k + 1], into[0, k + 2], into[0, k + 3]
        s0, s1, s2, s3 = into[1, k], into[1, k + 1], into[1, k + 2], into[1, k + 3]
        q0, q1, q2, q3 = plane_in[k], plane_in[k + 1], plane_in[k + 2], plane_in[k + 3]
        for i in range(n):
            s, enter, plane = slope[m, i], own[1, i], own_plane[1, i]
            at0, at1, at2, at3 = l0 + s * s0, l1 + s * s1, l2 + s * s2, l3 + s * s3
            plane, enter = q0 if at0 < enter else plane, min(at0, enter)
            plane, enter = q1 if at1 < enter else plane, min(at1, enter)
            plane, enter = q2 if at2 < enter else plane, min(at2, enter)
            plane, enter = q3 if at3 < enter else plane, min(at3, enter)
            own[1, i], own_plane[1, i] = enter, plane
    for k in range(0, hidden, 4):
        l0, l1, l2, l3 = out[0, k], out[0, k + 1], out[0, k + 2], out[0, k + 3]
        s0, s1, s2, s3 = out[1, k], out[1, k + 1], out[1, k + 2], out[1, k + 3]
        for i in range(n):
            s = slope[m, i]
            own[2, i] = max(max(max(l0 + s * s0, l1 + s * s1), max(l2 + s * s2, l3 + s * s3)), own[2, i])
    for i in range(n):
        enter, nearest = own[1, i], own[0, i]
        met = own[2, i] < enter < math.inf
        own[0, i] = enter if met else nearest
        own_plane[0, i] = own_plane[1, i] if met else own_plane[0, i]


@njit(cache=True, error_model="numpy", inline="always")
def _height(planes: Floats, q: int, seen: Floats, c: int) -> float:
    """How far the origin of column c is outside of plane q; over the range, it is the cosine of the incidence."""
    return float(planes[q, 0] * seen[0, c] + planes[q, 1] * seen[1, c] + planes[q, 2] * seen[2, c] - planes[q, 3])


@njit(cache=True, error_model="numpy", inline="always")
def _keep_nearer(
    a: int, planes: Floats, transmission: Floats, seen: Floats, c: int, m: int, own: Floats, own_plane: Ints,
    cos: Floats, nearness: Floats, target: Ints, surface: Ints, cosine: Floats, inner_surface: Ints,
) -> tuple[int, bool]:  # fmt: skip
    """End the rays of column m that meet body a first; return how many would alone, and whether any is on glass."""
    alone, panes = 0, False
    for i in range(cos.shape[1]):
        q, at = own_plane[0, i], own[0, i]
        if q != NONE:
            alone += 1
            if at > nearness[m, i]:
                nearness[m, i], target[m, i], surface[m, i], inner_surface[m, i] = at, a, q, NONE
                cosine[m, i] = _height(planes, q, seen, c) * at * cos[m, i]
                panes = panes or transmission[q] > 0.0
    return alone, panes


@njit(cache=True, error_model="numpy", inline="always")
def _look_inside(
    a: int, planes: Floats, transmission: Floats, seen: Floats, c: int, m: int, own: Floats, own_plane: Ints,
    cos: Floats, target: Ints, surface: Ints, inner_surface: Ints, inner_nearness: Floats, inner_cosine: Floats,
) -> None:  # fmt: skip
    """Let the rays of column m that end on a pane of body a go on to what is behind it."""
    for i in range(cos.shape[1]):
        q, at = own_plane[0, i], own[0, i]
        if q != NONE and target[m, i] == a and transmission[surface[m, i]] > 0.0:
            inner_surface[m, i], inner_nearness[m, i] = q, at
            inner_cosine[m, i] = _height(planes, q, seen, c) * at * cos[m, i]
