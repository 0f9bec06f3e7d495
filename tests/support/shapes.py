"""Builders of point sets with known lines, headings and outliers."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]

LAYER_BIAS_M = (0.016, 0.030, 0.045, 0.023)
"""Range offset of the four layers in the BLENSOR model of the LUX (sensor_facts 2)."""


def l_shape(heading: float, length: float = 4.0, width: float = 2.0, step: float = 0.25) -> Floats:
    """Return (N, 2) points on two perpendicular sides, evenly spaced from their common corner at (10, 5)."""
    along = np.arange(0.0, length + 1e-9, step)
    across = np.arange(step, width + 1e-9, step)
    body = np.concatenate([np.stack([along, 0 * along], axis=1), np.stack([0 * across, across], axis=1)])
    return body @ rotation(heading).T + np.array([10.0, 5.0])


def rotation(angle: float) -> Floats:
    """Return the (2, 2) rotation counter-clockwise by `angle`."""
    return np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])


def star(
    rng: np.random.Generator, outliers: int, lines: int = 5, per_line: int = 50, std: float = 0.0075
) -> tuple[Floats, npt.NDArray[np.int64]]:
    """Magri and Fusiello's star: chords of a regular polygon in the unit circle, and outliers in [-1, 1]^2.

    Returns (N, 2) points and (N,) the line of each, -1 for outliers.
    """
    tips = np.stack(
        [np.sin(2 * np.pi * np.arange(lines) / lines), np.cos(2 * np.pi * np.arange(lines) / lines)], axis=1
    )
    reach = (lines - 1) // 2
    points, label = [], []
    for k in range(lines):
        start, end = tips[k], tips[(k + reach) % lines]
        on_line = start + rng.random((per_line, 1)) * (end - start)
        points.append(on_line + rng.normal(0.0, std, (per_line, 2)))
        label.append(np.full(per_line, k))
    points.append(rng.uniform(-1.0, 1.0, (outliers, 2)))
    label.append(np.full(outliers, -1))
    return np.concatenate(points), np.concatenate(label).astype(np.int64)


def stairs(
    rng: np.random.Generator, outlier_share: float, steps: int = 4, per_step: int = 50, std: float = 0.0075
) -> tuple[Floats, npt.NDArray[np.int64]]:
    """Stairs like those of Toldo and Fusiello 2008: parallel segments in the unit square, and outliers all over it.

    They give the number of steps, sigma and the share of outliers. Assumed are the steps' width and height, 1 / `steps`
    each, evenly distributed points on each, and noise in both directions.

    Returns (N, 2) points and (N,) the step of each, -1 for outliers.
    """
    step = np.repeat(np.arange(steps), per_step)
    treads = np.stack([step + rng.random(len(step)), step + 0.5], axis=1) / steps
    outliers = round(outlier_share / (1.0 - outlier_share) * len(step))
    points = np.concatenate([treads + rng.normal(0.0, std, treads.shape), rng.random((outliers, 2))])
    return points, np.concatenate([step, np.full(outliers, -1)]).astype(np.int64)


@dataclass(frozen=True)
class Car:
    """A standing car seen by a four-layer scanner at the origin."""

    center: tuple[float, float] = (20.0, 0.0)
    heading: float = 0.0
    size: tuple[float, float] = (4.7, 1.8)
    chamfer: float = 0.35
    """Length cut off each corner of the outline [m]."""
    window_depth: float = 0.0
    """Depth of the rear window hit by the top layer, behind the rear [m]; 0 for a flat rear."""
    mirrors: bool = False
    """True if layer 2 hits side mirrors."""
    range_std: float = 0.025
    layer_bias: tuple[float, ...] = LAYER_BIAS_M


def outline(front: float, rear: float, half_width: float, chamfer: float) -> Floats:
    """Return (8, 2) corners of a counter-clockwise box from -rear to front with cut corners."""
    c, w = chamfer, half_width
    return np.array(
        [
            *([front - c, -w], [front, c - w], [front, w - c], [front - c, w]),
            *([c - rear, w], [-rear, w - c], [-rear, c - w], [c - rear, -w]),
        ]
    )


def layer_bodies(car: Car, layer: int) -> list[Floats]:
    """Return the convex outlines that a layer hits, in the car's frame: the body, and mirrors for layer 2."""
    length, width = car.size
    deep = car.window_depth if layer == 3 else 0.0
    bodies = [outline(length / 2, length / 2 - deep, width / 2 - 0.15 * (deep > 0), car.chamfer)]
    if car.mirrors and layer == 2:
        box = outline(0.07, 0.07, 0.1, 0.02)
        bodies += [box + np.array([0.16 * length, side * (width / 2 + 0.1)]) for side in (-1.0, 1.0)]
    return bodies


def depth_inside(car: Car, points: Floats) -> Floats:
    """Return the (N,) depth of points inside the car's box, negative outside [m]."""
    local = (points - np.array(car.center)) @ rotation(car.heading)
    return np.min(0.5 * np.array(car.size) - np.abs(local), axis=1)


def cast(polygon: Floats, directions: Floats) -> Floats:
    """Return the (B,) ranges at which rays from the origin enter a convex counter-clockwise polygon; inf for misses."""
    edges = np.roll(polygon, -1, axis=0) - polygon
    normals = np.stack([edges[:, 1], -edges[:, 0]], axis=1)
    offset = np.sum(normals * polygon, axis=1)
    speed = directions @ normals.T
    with np.errstate(divide="ignore", invalid="ignore"):
        crossing = offset / speed
    enter = np.max(np.where(speed < 0, crossing, -np.inf), axis=1)
    leave = np.min(np.where(speed > 0, crossing, np.inf), axis=1)
    return np.where((enter <= leave) & (enter > 0), enter, np.inf)


def scan_car(car: Car, rng: np.random.Generator, step_deg: float = 0.5) -> tuple[Floats, npt.NDArray[np.bool_]]:
    """Return (N, 2) points of a car, and the (N,) mask of points off its outline, on mirrors or windows.

    Layers 0 and 1 fire between the beams of layers 2 and 3, as in the LUX (sensor_facts 1.2).
    """
    bearing = np.arctan2(car.center[1], car.center[0])
    true_points, points = [], []
    for layer in range(4):
        phase = 0.5 * step_deg * (layer // 2)
        angle = bearing + np.deg2rad(np.arange(-30.0, 30.0, step_deg) + phase + rng.uniform(0.0, 0.01))
        directions = np.stack([np.cos(angle), np.sin(angle)], axis=1)
        bodies = [body @ rotation(car.heading).T + car.center for body in layer_bodies(car, layer)]
        ranges = np.min([cast(body, directions) for body in bodies], axis=0)
        hit = np.isfinite(ranges)
        noise = rng.normal(0.0, car.range_std, hit.sum()) + car.layer_bias[layer]
        true_points.append(directions[hit] * ranges[hit, None])
        points.append(directions[hit] * (ranges[hit] + noise)[:, None])
    depth = depth_inside(car, np.concatenate(true_points))
    return np.concatenate(points), (depth < -0.001) | (depth > 0.2)
