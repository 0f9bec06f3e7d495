"""Beams against the world: what each beam meets first, without loss or noise."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from sensor_model import kernels
from sensor_model.beams import BeamTable
from sensor_model.bodies import Bodies
from sensor_model.kernels import GROUND, NOTHING, WALL
from sensor_model.truth import Part
from sensor_model.walls import Walls

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]

GROUND_REFLECTIVITY = 0.2
"""Diffuse reflectivity of dry asphalt at 905 nm; an estimate."""
GLASS_REFLECTIVITY = 0.2
"""Of a greenhouse, panes and what is behind them taken together; an estimate."""
TYRE_REFLECTIVITY = 0.05
"""Carbon-black rubber; an estimate, as for black paint."""

_FIXED_REFLECTIVITY = np.zeros(len(Part))
_FIXED_REFLECTIVITY[Part.GROUND] = GROUND_REFLECTIVITY
_FIXED_REFLECTIVITY[Part.GREENHOUSE] = GLASS_REFLECTIVITY
_FIXED_REFLECTIVITY[Part.WHEEL] = TYRE_REFLECTIVITY


@dataclass(frozen=True, slots=True, eq=False)
class Hits:
    """The H beams that meet something within their unit's range, in the order of the beam table."""

    beam: Ints
    """(H,) row of the beam table."""
    range: Floats
    """(H,) [m]."""
    target: Ints
    """(H,) actor, or `GROUND` or `WALL`."""
    part: npt.NDArray[np.uint8]
    """(H,) `Part`."""
    surface: Ints
    """(H,) plane of `Bodies` on actors, wall of `Walls` on walls, 0 on the ground."""
    point_body: Floats
    """(H, 2) the point in the frame of the actor it is on [m]; zero elsewhere."""
    cosine: Floats
    """(H,) cosine of the angle of incidence."""
    reflectivity: Floats
    """(H,) diffuse, of the surface."""
    alone: Ints
    """(A,) beams that would end on each actor if it were alone on the ground."""


class Caster:
    """Casts a rig's beams, one ray along each beam's centre. The ground is the plane z = 0."""

    def __init__(self, beams: BeamTable) -> None:
        self._beams = beams
        down = -beams.direction_ego[:, 2]
        height = beams.origin_ego[beams.unit, 2]
        to_ground = np.divide(height, down, out=np.full(len(beams), np.inf), where=down > 0.0)
        self._open_range = np.minimum(to_ground, beams.range_max)
        self._open_target = np.where(to_ground < beams.range_max, GROUND, NOTHING)
        self._open_cosine = np.maximum(down, 0.0)
        self._reach = float(beams.range_max.max() + np.linalg.norm(beams.origin_ego, axis=1).max())

    def cast(self, bodies: Bodies, walls: Walls, paint: Floats) -> Hits:
        """Find what every beam meets first.

        Parameters
        ----------
        bodies, walls
            In the ego frame.
        paint
            (A,) diffuse reflectivity of each body's paint.
        """
        beams = self._beams
        nearest, target, cosine = self._open_range.copy(), self._open_target.copy(), self._open_cosine.copy()
        surface = np.zeros(len(beams), dtype=np.int64)
        point_body = np.zeros((len(beams), 2))
        alone = np.zeros(len(bodies), dtype=np.int64)
        kernels.cast_walls(
            walls.ends, walls.height, self._reach,
            beams.origin_ego, beams.R_ego_unit, beams.unit_row, beams.row_beam, beams.row_azimuth, beams.direction_ego,
            nearest, target, surface, cosine,
        )  # fmt: skip
        kernels.cast_bodies(
            bodies.pose_ego, bodies.bounds, bodies.body_solid, bodies.solid_plane, bodies.planes,
            beams.origin_ego, beams.R_ego_unit, beams.unit_row, beams.row_beam, beams.row_azimuth, beams.direction_ego,
            beams.range_min, self._open_range,
            nearest, target, surface, cosine, point_body, alone,
        )  # fmt: skip
        beam = np.flatnonzero((target != NOTHING) & (nearest >= beams.range_min))
        target, surface = target[beam], surface[beam]
        part = _part(target, surface, bodies)
        return Hits(
            beam=beam,
            range=nearest[beam],
            target=target,
            surface=surface,
            part=part,
            cosine=cosine[beam],
            point_body=point_body.take(beam, axis=0),
            reflectivity=_reflectivity(target, surface, part, walls, paint),
            alone=alone,
        )


def _part(target: Ints, surface: Ints, bodies: Bodies) -> npt.NDArray[np.uint8]:
    part = np.where(target == GROUND, Part.GROUND, Part.OBSTACLE).astype(np.uint8)
    on_actor = target >= 0
    part[on_actor] = bodies.plane_part[surface[on_actor]]
    return part


def _reflectivity(target: Ints, surface: Ints, part: npt.NDArray[np.uint8], walls: Walls, paint: Floats) -> Floats:
    reflectivity = _FIXED_REFLECTIVITY[part]
    painted = (part == Part.BODY) | (part == Part.MIRROR)
    reflectivity[painted] = paint[target[painted]]
    on_wall = target == WALL
    reflectivity[on_wall] = walls.reflectivity[surface[on_wall]]
    return reflectivity
