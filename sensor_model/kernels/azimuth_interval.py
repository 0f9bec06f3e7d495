"""Azimuth intervals that boxes around bodies and walls cover, seen from a unit."""

import math

from luxloop import elementary
from luxloop.arrays import Floats
from luxloop.compiled import kernel


@kernel()
def body_interval(
    bounds: Floats, motion: Floats, a: int, margin: float, origin: Floats, rotation: Floats, x: Floats, y: Floats
) -> tuple[float, float]:
    """Return the lowest and highest azimuth of body a's box enlarged by a margin; `x` and `y` (8,) are work arrays."""
    cos, sin = elementary.cos(motion[a, 2]), elementary.sin(motion[a, 2])
    for i in range(8):
        front, left, top = i & 1, (i >> 1) & 1, (i >> 2) & 1
        bx = bounds[a, front, 0] + (2 * front - 1) * margin
        by = bounds[a, left, 1] + (2 * left - 1) * margin
        ex, ey = motion[a, 0] + cos * bx - sin * by - origin[0], motion[a, 1] + sin * bx + cos * by - origin[1]
        x[i], y[i] = _in_unit_frame(ex, ey, bounds[a, top, 2] - origin[2], rotation)
    return _hull_interval(x, y)


@kernel()
def wall_interval(
    ends: Floats, z: Floats, w: int, margin: float, origin: Floats, rotation: Floats, x: Floats, y: Floats
) -> tuple[float, float]:
    """Return the same of a box around wall w enlarged by a margin."""
    ex, ey = ends[w, 2] - ends[w, 0], ends[w, 3] - ends[w, 1]
    ux, uy = margin * ex / elementary.hypot(ex, ey), margin * ey / elementary.hypot(ex, ey)
    for i in range(8):
        far, left, top = i & 1, (i >> 1) & 1, (i >> 2) & 1
        along, across = 2 * far - 1, 2 * left - 1
        wx = ends[w, 0] + far * ex + along * ux - across * uy - origin[0]
        wy = ends[w, 1] + far * ey + along * uy + across * ux - origin[1]
        x[i], y[i] = _in_unit_frame(wx, wy, z[w, top] - origin[2], rotation)
    return _hull_interval(x, y)


@kernel()
def _in_unit_frame(x: float, y: float, z: float, rotation: Floats) -> tuple[float, float]:
    """Return x and y of a vector in the frame of a unit."""
    return (
        rotation[0, 0] * x + rotation[1, 0] * y + rotation[2, 0] * z,
        rotation[0, 1] * x + rotation[1, 1] * y + rotation[2, 1] * z,
    )


@kernel(error_model="numpy")
def _hull_interval(x: Floats, y: Floats) -> tuple[float, float]:
    """Return the azimuth interval of the convex hull of 8 points; infinite if the origin may be inside."""
    cx, cy = 0.0, 0.0
    for i in range(8):
        cx, cy = cx + x[i], cy + y[i]
    # Tangents of the angles to the mean direction order the points as long as all are ahead.
    low, high, behind = 0.0, 0.0, False
    for i in range(8):
        ahead, aside = cx * x[i] + cy * y[i], cx * y[i] - cy * x[i]
        low, high, behind = min(low, aside / ahead), max(high, aside / ahead), behind or ahead <= 0.0
    if behind:
        return _wide_interval(x, y, cx, cy)
    centre = elementary.atan2(cy, cx)
    return centre + elementary.atan(low), centre + elementary.atan(high)


@kernel()
def _wide_interval(x: Floats, y: Floats, cx: float, cy: float) -> tuple[float, float]:
    """Return the same if a point is more than a right angle away from the mean direction (cx, cy)."""
    low, high = 0.0, 0.0
    for i in range(8):
        turned = elementary.atan2(cx * y[i] - cy * x[i], cx * x[i] + cy * y[i])
        low, high = min(low, turned), max(high, turned)
    if high - low >= math.pi or (cx == 0.0 and cy == 0.0):
        return -math.inf, math.inf
    centre = elementary.atan2(cy, cx)
    return centre + low, centre + high
