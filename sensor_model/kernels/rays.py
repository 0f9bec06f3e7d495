"""Rays against the ground, walls and bodies.

A fan fires columns: at each azimuth n rays from one point at one time, in one plane. Rays are held in arrays (n, M) over
M columns; column m has its origin, forward and up in `column[:, m]` (9, M), and its ray i goes along
cos[i, m] forward + sin[i, m] up. The inner loops run over columns and hold no branch, so that the compiler can
vectorise them; hence `error_model="numpy"`: a division by zero is infinite.
"""

import math

import numpy as np
from numba import njit

from sensor_model.kernels.records import Bools, Floats, Ints

NONE = -1
"""No plane."""
_SLACK = 1e-9  # rounding must not lose a ray that just grazes a thing


@njit(cache=True, error_model="numpy")
def meet_ground(
    column: Floats, cos: Floats, sin: Floats, range_max: float, ground: int, nothing: int,
    open_range: Floats, nearest: Floats, target: Ints, surface: Ints, cosine: Floats, inner_range: Floats,
) -> None:  # fmt: skip
    """Start the rays: they end on the ground, the plane z = 0, or at the farthest range on nothing."""
    for i in range(len(cos)):
        for m in range(column.shape[1]):
            fall = -(cos[i, m] * column[5, m] + sin[i, m] * column[8, m])
            t = column[2, m] / fall if fall > 0.0 else math.inf
            end = min(t, range_max)
            open_range[i, m], nearest[i, m] = end, end
            target[i, m] = ground if t < range_max else nothing
            surface[i, m] = 0
            cosine[i, m] = fall
            inner_range[i, m] = math.inf


@njit(cache=True, error_model="numpy")
def meet_wall(
    column: Floats, cos: Floats, sin: Floats, first: int, end: int, ends: Floats, z: Floats, w: int, wall: int,
    nearest: Floats, target: Ints, surface: Ints, cosine: Floats,
) -> None:  # fmt: skip
    """Shorten the rays of columns [first, end) that meet wall w of `walls.Walls`; as a target it is called `wall`."""
    ex, ey = ends[w, 2] - ends[w, 0], ends[w, 3] - ends[w, 1]
    length = math.hypot(ex, ey)
    ex, ey = ex / length, ey / length
    for i in range(len(cos)):
        for m in range(first, end):
            gx, gy = ends[w, 0] - column[0, m], ends[w, 1] - column[1, m]
            dx, dy = cos[i, m] * column[3, m] + sin[i, m] * column[6, m], cos[i, m] * column[4, m] + sin[i, m] * column[7, m]
            towards = dx * ey - dy * ex
            t = (gx * ey - gy * ex) / towards
            along = (t * dx - gx) * ex + (t * dy - gy) * ey
            height = column[2, m] + t * (cos[i, m] * column[5, m] + sin[i, m] * column[8, m])
            if 0.0 < t < nearest[i, m] and 0.0 <= along <= length and z[w, 0] <= height <= z[w, 1]:
                nearest[i, m], target[i, m], surface[i, m], cosine[i, m] = t, wall, w, abs(towards)


@njit(cache=True)
def into_body(column: Floats, first: int, end: int, per: int, time: Floats, motion: Floats, a: int, seen: Floats) -> None:
    """Fill `seen` (9, M) with columns [first, end) in the frame of body a at their time; `per` columns share a time.

    `motion` is that of `records.Solids`.
    """
    for k in range(first // per, end // per):
        t, half = time[k], 0.5 * time[k] * time[k]
        x = motion[a, 0] + motion[a, 3] * t + motion[a, 5] * half
        y = motion[a, 1] + motion[a, 4] * t + motion[a, 6] * half
        yaw = motion[a, 2] + motion[a, 7] * t
        cos, sin = math.cos(yaw), math.sin(yaw)
        for m in range(k * per, (k + 1) * per):
            dx, dy = column[0, m] - x, column[1, m] - y
            seen[0, m], seen[1, m], seen[2, m] = cos * dx + sin * dy, cos * dy - sin * dx, column[2, m]
            for axis in (3, 6):
                seen[axis, m] = cos * column[axis, m] + sin * column[axis + 1, m]
                seen[axis + 1, m] = cos * column[axis + 1, m] - sin * column[axis, m]
                seen[axis + 2, m] = column[axis + 2, m]


@njit(cache=True, error_model="numpy")
def enter_body(
    inner: bool, a: int, body_solid: Ints, solid_plane: Ints, solid_bounds: Floats, solid_inner: Bools, planes: Floats,
    seen: Floats, first: int, end: int, cos: Floats, sin: Floats, limit: Floats, own_range: Floats, own_surface: Ints,
) -> None:  # fmt: skip
    """Where the rays of columns [first, end) enter the inner or the outer solids of body a, up to a limit (n, M).

    Parameters
    ----------
    body_solid, solid_plane, solid_bounds, solid_inner, planes
        As in `bodies.Bodies`.
    seen
        The columns in the body's frame.
    own_range, own_surface
        (n, M) out: range, and the plane, NONE where the ray does not.
    """
    most = 0
    for p in range(body_solid[a], body_solid[a + 1]):
        most = max(most, solid_plane[p + 1] - solid_plane[p])
    n, columns, start = len(cos), end - first, np.uint64(first)
    slope, nearness, room = np.empty((n, columns)), np.empty((n, columns)), np.empty((4, most, columns))
    for i in range(n):
        for c in range(np.uint64(columns)):
            slope[i, c] = sin[i, start + c] / cos[i, start + c]
            nearness[i, c] = 1.0 / (limit[i, start + c] * cos[i, start + c])
            own_surface[i, start + c] = NONE
    reach = np.empty((6, columns))
    _reach(seen, first, cos, sin, reach)
    for p in range(body_solid[a], body_solid[a + 1]):
        if solid_inner[p] == inner:
            left, right = _columns_at(solid_bounds, p, seen, first, reach)
            _enter_solid(
                planes, solid_plane[p], solid_plane[p + 1], seen, first, left, right, slope, nearness, own_surface, room
            )
    for i in range(n):
        for c in range(np.uint64(columns)):
            own_range[i, start + c] = 1.0 / (nearness[i, c] * cos[i, start + c])


@njit(cache=True, error_model="numpy")
def incidence(planes: Floats, q: int, seen: Floats, m: int, cos: float, sin: float) -> float:
    """Cosine of the angle between a ray of column m and the inward normal of plane q."""
    forward = planes[q, 0] * seen[3, m] + planes[q, 1] * seen[4, m] + planes[q, 2] * seen[5, m]
    upward = planes[q, 0] * seen[6, m] + planes[q, 1] * seen[7, m] + planes[q, 2] * seen[8, m]
    return -(cos * forward + sin * upward)


@njit(cache=True, error_model="numpy")
def _reach(seen: Floats, first: int, cos: Floats, sin: Floats, reach: Floats) -> None:
    """Fill (6, C), for columns from `first` on: lowest and highest direction in plan of each column (x, y, x, y), and bounds of all slopes between.

    Slope is height over distance in plan. A ray between the lowest l and the highest h is a l + b h with a, b >= 0. It is
    steeper than both where they point apart in plan, by an angle v, for then |a l + b h| there is shorter than
    a |l| + b |h|: down to cos(v / 2) of it.
    """
    low, high = 0, 0
    for i in range(len(cos)):
        low = i if sin[i, first] < sin[low, first] else low
        high = i if sin[i, first] > sin[high, first] else high
    for c in range(reach.shape[1]):
        m = first + c
        lx, ly = cos[low, m] * seen[3, m] + sin[low, m] * seen[6, m], cos[low, m] * seen[4, m] + sin[low, m] * seen[7, m]
        hx, hy = cos[high, m] * seen[3, m] + sin[high, m] * seen[6, m], cos[high, m] * seen[4, m] + sin[high, m] * seen[7, m]
        plan_low, plan_high = math.sqrt(lx * lx + ly * ly), math.sqrt(hx * hx + hy * hy)
        steeper = 1.0 / math.sqrt(0.5 * (1.0 + (lx * hx + ly * hy) / (plan_low * plan_high)) + 1e-12)
        one = (cos[low, m] * seen[5, m] + sin[low, m] * seen[8, m]) / plan_low
        other = (cos[high, m] * seen[5, m] + sin[high, m] * seen[8, m]) / plan_high
        fall, climb = min(one, other), max(one, other)
        reach[0, c], reach[1, c], reach[2, c], reach[3, c] = lx, ly, hx, hy
        reach[4, c] = min(fall, fall * steeper) - _SLACK
        reach[5, c] = max(climb, climb * steeper) + _SLACK


@njit(cache=True, error_model="numpy")
def _columns_at(bounds: Floats, p: int, seen: Floats, first: int, reach: Floats) -> tuple[int, int]:
    """Range of the columns, counted from `first`, that holds all with a ray that may meet the box around solid p."""
    length, width = 0.5 * (bounds[p, 1, 0] - bounds[p, 0, 0]), 0.5 * (bounds[p, 1, 1] - bounds[p, 0, 1])
    cx, cy = 0.5 * (bounds[p, 0, 0] + bounds[p, 1, 0]), 0.5 * (bounds[p, 0, 1] + bounds[p, 1, 1])
    radius = math.sqrt(length * length + width * width)
    columns = reach.shape[1]
    left, right = columns, 0
    for c in range(columns):
        m = first + c
        x, y = cx - seen[0, m], cy - seen[1, m]
        lx, ly, hx, hy = reach[0, c], reach[1, c], reach[2, c], reach[3, c]
        # How far the centre is to the left of a ray, against how far the box reaches across it.
        left_of_low, left_of_high = lx * y - ly * x, hx * y - hy * x
        across_low = abs(lx) * width + abs(ly) * length + _SLACK
        across_high = abs(hx) * width + abs(hy) * length + _SLACK
        distance = math.sqrt(x * x + y * y)
        near, far = max(0.0, distance - radius), distance + radius
        top = seen[2, m] + max(reach[5, c] * near, reach[5, c] * far)
        bottom = seen[2, m] + min(reach[4, c] * near, reach[4, c] * far)
        missed = (
            (left_of_low > across_low) & (left_of_high > across_high)
            | (left_of_low < -across_low) & (left_of_high < -across_high)
            | (lx * x + ly * y < -radius) & (hx * x + hy * y < -radius)
            | (top < bounds[p, 0, 2])
            | (bottom > bounds[p, 1, 2])
        )
        left = min(left, columns if missed else c)
        right = max(right, 0 if missed else c + 1)
    return left, right


@njit(cache=True, error_model="numpy")
def _enter_solid(
    planes: Floats, begin: int, stop: int, seen: Floats, first: int, left: int, right: int, slope: Floats,
    nearness: Floats, own_surface: Ints, room: Floats,
) -> None:  # fmt: skip
    """Update the nearness (n, C) of what rays meet by the convex solid n . p <= d of planes [begin, stop).

    A ray of slope s from o towards f + s u meets a plane at the nearness 1 / t = (n . f + s n . u) / (d - n . o), which is
    linear in s. It enters the solid at the least nearness of the planes that o is outside of, if that is positive, and
    has not left it by then if it is more than that of any plane that o is inside of. No ray needs a division.

    Parameters
    ----------
    left, right
        Only these columns c are looked at; they are columns first + c of `seen` and `own_surface`.
    room
        (4, K, C) to work in.
    """
    if left >= right:
        return
    into, into_per_slope, out, out_per_slope = room[0], room[1], room[2], room[3]
    facing, hidden = 0, 0
    order = np.empty((2, stop - begin), np.int64)
    # Unsigned, or each index would be checked for being negative, and no loop vectorised.
    start, low, high = np.uint64(first), np.uint64(left), np.uint64(right)
    for q in range(stop - begin):
        nx, ny, nz, d = planes[begin + q, 0], planes[begin + q, 1], planes[begin + q, 2], planes[begin + q, 3]
        outside = 0
        for c in range(low, high):
            m = start + c
            inward = d - nx * seen[0, m] - ny * seen[1, m] - nz * seen[2, m]
            forward = (nx * seen[3, m] + ny * seen[4, m] + nz * seen[5, m]) / inward
            upward = (nx * seen[6, m] + ny * seen[7, m] + nz * seen[8, m]) / inward
            into[q, c], into_per_slope[q, c] = (forward, upward) if inward < 0.0 else (math.inf, 0.0)
            out[q, c], out_per_slope[q, c] = (forward, upward) if inward > 0.0 else (-math.inf, 0.0)
            outside += inward < 0.0
        if outside > 0:
            order[0, facing] = q
            facing += 1
        if outside < right - left:
            order[1, hidden] = q
            hidden += 1
    if facing == 0:
        return
    enter, leave, plane = np.empty(right), np.empty(right), np.empty(right, np.int64)
    for i in range(len(slope)):
        for c in range(low, high):
            enter[c], leave[c], plane[c] = math.inf, nearness[i, c], NONE
        for k in range(facing):
            q = order[0, k]
            for c in range(low, high):
                at = into[q, c] + slope[i, c] * into_per_slope[q, c]
                later = at < enter[c]
                enter[c] = at if later else enter[c]
                plane[c] = begin + q if later else plane[c]
        for k in range(hidden):
            q = order[1, k]
            for c in range(low, high):
                at = out[q, c] + slope[i, c] * out_per_slope[q, c]
                leave[c] = at if at > leave[c] else leave[c]
        for c in range(low, high):
            met = leave[c] < enter[c] < math.inf
            nearness[i, c] = enter[c] if met else nearness[i, c]
            own_surface[i, start + c] = plane[c] if met else own_surface[i, start + c]
