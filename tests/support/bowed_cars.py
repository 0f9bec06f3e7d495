"""Builder of the points of a car with bowed flanks, front and rear, seen from the origin."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from support.shapes import Floats, rotation

Ints = npt.NDArray[np.int64]


@dataclass(frozen=True)
class BowedCar:
    """Outline in plan: the sagitta of each side grows with the square of the distance from its middle."""

    center: tuple[float, float] = (20.0, 0.0)
    heading: float = 0.0
    size: tuple[float, float] = (4.4, 1.8)
    flank_sagitta: float = 0.02 * 2.2**2
    """Bow of a flank over half of the length [m]."""
    end_sagitta: float = 0.22 * 0.9**2
    """Bow of an end over half of the width [m]."""
    range_std: float = 0.0
    scatter: float = 0.0
    """Standard deviation of points across a face for other reasons [m]."""
    inside_share: float = 0.0
    """Share of points inside, exponentially deep with a mean of 1 m."""


def visible_points(car: BowedCar, per_face: int, rng: np.random.Generator) -> tuple[Floats, Ints]:
    """Return (N, 2) points on the flank and end that face the origin, and (N,) 0 on the flank, 1 on the end.

    Points are up to `per_face` on each, evenly spaced in the car's frame; without an end if the origin is beside the
    car. Where the two sides meet, the outline is their intersection; they have full length at their other ends.
    """
    length, width = car.size
    eye = -np.array(car.center) @ rotation(car.heading)
    place = np.linspace(-1.0, 1.0, per_face)
    along, across = np.sign(eye[0] or 1.0), np.sign(eye[1] or 1.0)
    flank = np.stack([0.5 * length * place, across * (0.5 * width - car.flank_sagitta * place**2)], axis=1)
    end = np.stack([along * (0.5 * length - car.end_sagitta * place**2), 0.5 * width * place], axis=1)
    seen = np.repeat([abs(eye[1]) > 0.5 * width, abs(eye[0]) > 0.5 * length], per_face)
    if seen.all():
        beyond_end = along * flank[:, 0] > 0.5 * length - car.end_sagitta * (2.0 * flank[:, 1] / width) ** 2
        beyond_flank = across * end[:, 1] > 0.5 * width - car.flank_sagitta * (2.0 * end[:, 0] / length) ** 2
        seen = ~np.concatenate([beyond_end, beyond_flank])
    inward = np.repeat([[0.0, -across], [-along, 0.0]], per_face, axis=0)
    depth = rng.normal(0.0, car.scatter, 2 * per_face) if car.scatter else np.zeros(2 * per_face)
    depth += np.where(rng.random(2 * per_face) < car.inside_share, rng.exponential(1.0, 2 * per_face), 0.0)
    local = np.concatenate([flank, end]) + depth[:, None] * inward
    points = local[seen] @ rotation(car.heading).T + car.center
    return ranged(points, car.range_std, rng), np.repeat([0, 1], per_face)[seen]


def drawn_car(rng: np.random.Generator) -> BowedCar:
    """Return a car at 6 to 40 m, with the bows of the tracker's prior, noise, scatter and points inside."""
    bearing, distance = rng.uniform(-np.pi, np.pi), rng.uniform(6.0, 40.0)
    length, width = rng.uniform(3.8, 5.0), rng.uniform(1.6, 2.0)
    return BowedCar(
        center=(distance * np.cos(bearing), distance * np.sin(bearing)),
        heading=rng.uniform(-np.pi, np.pi),
        size=(length, width),
        flank_sagitta=rng.normal(0.02, 0.02) * (0.5 * length) ** 2,
        end_sagitta=rng.normal(0.22, 0.5) * (0.5 * width) ** 2,
        range_std=0.027,
        scatter=0.02,
        inside_share=0.03,
    )


def shifted_lines(car: BowedCar, points: Floats, line: Ints, side: Ints, rng: np.random.Generator) -> Floats:
    """Return points (N, 2) with an offset of 0.1 m in depth per scan line and side, normally distributed."""
    eye = -np.array(car.center) @ rotation(car.heading)
    inward = -np.array([[0.0, np.sign(eye[1])], [np.sign(eye[0]), 0.0]]) @ rotation(car.heading).T
    offset = rng.normal(0.0, 0.1, (2, line.max() + 1))
    return np.asarray(points + offset[side, line][:, None] * inward[side])


def ranged(points: Floats, std: float, rng: np.random.Generator) -> Floats:
    """Return points (N, 2) with range noise along their beams."""
    distance = np.linalg.norm(points, axis=1, keepdims=True)
    return np.asarray(points * (1.0 + std * rng.normal(size=distance.shape) / distance))
