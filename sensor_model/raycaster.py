"""Ray caster: the echoes of each beam, without noise, on the solids or on the relief of their surfaces."""

from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from luxloop import elementwise
from luxloop.arrays import Floats, Ints
from luxloop.sensor_model.bodies.scene import Bodies
from luxloop.sensor_model.bodies.walls import Walls
from luxloop.sensor_model.kernels import records
from luxloop.sensor_model.kernels.culling import rig_reach
from luxloop.sensor_model.kernels.point_shift import shift_to_relief
from luxloop.sensor_model.kernels.points import points_on_bodies
from luxloop.sensor_model.kernels.records import RoughPlanes
from luxloop.sensor_model.kernels.rig_scan import cast_rig, pack_echoes
from luxloop.sensor_model.kernels.secondary_rays import cast_rays
from luxloop.sensor_model.noise.ghosts import Mirrored
from luxloop.sensor_model.rig.beams import BeamTable
from luxloop.sensor_model.scan_context import ScanContext
from luxloop.sensor_model.sensor_config import SensorConfig

GROUND_REFLECTIVITY = 0.2
"""Diffuse reflectivity of dry asphalt at 905 nm; an estimate."""


@dataclass(frozen=True, slots=True, eq=False)
class Echoes:
    """N echoes, ordered by beam and from near to far, and L beams that hit something and have no echo."""

    beam: Ints
    """(N,) row of the beam table."""
    range: Floats
    """(N,) leading edge [m]."""
    width: Floats
    """(N,) width of the pulse above the threshold [m]."""
    power: Floats
    """(N,) highest power [1/m^2]."""
    target: Ints
    """(N,) row of the actor, or `GROUND`, `WALL`."""
    surface: Ints
    """(N,) plane of `Bodies` on actors, wall of `Walls` on walls, 0 on the ground."""
    point_body: Floats
    """(N, 3) the point, on the centre of its beam, in the frame of the actor it is on [m]; zero elsewhere."""
    direction_body: Floats
    """(N, 3) direction of the beam in that frame; zero elsewhere."""
    lost_beam: Ints
    """(L,) row of the beam table."""
    lost_power: Floats
    """(L,) highest power that returned [1/m^2]."""
    lost_range: Floats
    """(L,) range of that power [m]; 0 if all hits are nearer than the unit measures."""
    free_range: Floats
    """(B,) unobstructed range of each beam, infinite without a hit; (0,) unless requested [m]."""
    unit_hits: npt.NDArray[np.int32]
    """(A, U) rays that end on each actor."""
    unit_hits_alone: npt.NDArray[np.int32]
    """(A, U) rays that would end on each actor if it were alone on the ground."""


class Raycaster:
    """Ray caster of a rig: each beam is a grid of rays over its footprint. The ground is that of the context.

    Parameters
    ----------
    refine
        If True, only beams across an edge of a body are traced with all their rays; the echoes are the same.
    """

    def __init__(self, beams: BeamTable, sensor: SensorConfig, *, refine: bool = True) -> None:
        self._beams = beams
        self._unit = beams.unit.astype(np.int64)
        self._fans = records.Fans(beams.fan_unit, beams.fan_row, beams.fan_azimuth, beams.fan_turn, beams.row_beam)
        self._grid = _grid(beams, sensor.footprint, refine and sensor.footprint != (1, 1))
        self._direction = np.hstack([_cos_sin(beams.azimuth), _cos_sin(beams.elevation)])
        self._time = beams.time_offset if sensor.sweep else np.zeros(len(beams))
        self._longest = float(np.abs(self._time).max())
        # Reused by all scans: fresh memory from the system costs more time than casting a body.
        slots = (len(beams), int(beams.units.echoes_max.max()))
        self._echo, self._echo_id = np.empty((3, *slots)), np.empty((2, *slots), dtype=np.int64)
        self._lost_echo = np.empty((2, len(beams)))

    def firing_time(self, context: ScanContext) -> Floats:
        """Return the (B,) true firing time of each beam relative to the frame's time [s]."""
        if not context.time_jitter.any():
            return self._time
        return self._time + context.time_jitter[self._unit]

    def reach(self, context: ScanContext) -> float:
        """Return the largest distance from the ego at which a static object can affect the scan [m].

        This covers ghosts too: no unit reports one beyond its range, and a path by way of a mirror is never shorter.
        """
        time = self._longest + float(np.abs(context.time_jitter).max())
        return rig_reach(context.origin_ego, self._beams.units.range_max, time, context.drive)

    def cast(self, bodies: Bodies, walls: Walls, context: ScanContext, *, free_range: bool = False) -> Echoes:
        """Return the echoes of all beams.

        Parameters
        ----------
        bodies, walls
            In the ego frame.
        free_range
            If True, `Echoes.free_range` is computed.
        """
        free = np.full(len(self._beams) if free_range else 0, np.inf)
        hits, hits_alone = np.zeros((2, len(self._beams.units), len(bodies)), dtype=np.int64)
        beams, units, solids, drive = self._timed(context), self._units(context), _solids(bodies), context.drive
        out = records.ScanBuffers(
            self._echo, self._echo_id, np.zeros(len(self._beams), np.int64), np.zeros(len(self._beams), np.bool_),
            self._lost_echo, free, hits, hits_alone,
        )  # fmt: skip
        static = _static_scene(walls, context)
        cast_rig(self._fans, self._grid, beams, units, solids, static, drive, context.frame_index, out)
        echo, echo_id, lost_beam, lost_echo = pack_echoes(out)
        beam, distance, target = echo_id[records.BEAM], echo[records.RANGE], echo_id[records.TARGET]
        tilts = records.BodyTilts(bodies.R_level_body, bodies.ground_z)
        point, direction = points_on_bodies(
            beam, self._unit, distance, target, beams, units, solids.motion, tilts, drive
        )
        return Echoes(
            beam=beam,
            range=distance,
            width=echo[records.WIDTH],
            power=echo[records.POWER],
            target=target,
            surface=echo_id[records.SURFACE],
            point_body=point,
            direction_body=direction,
            lost_beam=lost_beam,
            lost_power=lost_echo[records.POWER],
            lost_range=lost_echo[records.RANGE],
            free_range=free,
            unit_hits=hits.T.astype(np.int32),
            unit_hits_alone=hits_alone.T.astype(np.int32),
        )

    def cast_mirrored(
        self, beam: Ints, origins_ego: Floats, directions_ego: Floats, reach: Floats, bodies: Bodies, walls: Walls,
        context: ScanContext,
    ) -> Mirrored:  # fmt: skip
        """Cast rays from origins (G, 3) along directions (G, 3) up to a reach (G,), each when its beam (G,) fires."""
        time = self._time[beam] + context.time_jitter[self._unit[beam]]
        static = _static_scene(walls, context)
        # Indexed rows may come in either memory order; one order only is compiled.
        origin, direction = np.ascontiguousarray(origins_ego), np.ascontiguousarray(directions_ego)
        return Mirrored(*cast_rays(origin, direction, time, reach, _solids(bodies), static))

    def _timed(self, context: ScanContext) -> records.Beams:
        return records.Beams(self._direction, self._beams.gain, context.threshold, self.firing_time(context))

    def _units(self, context: ScanContext) -> records.Units:
        units = self._beams.units
        return records.Units(
            context.origin_ego, context.R_ego_unit, units.range_min, units.range_max, units.pulse_length,
            units.pulse_growth, units.echo_separation, units.echoes_max,
        )  # fmt: skip


def _grid(beams: BeamTable, footprint: tuple[int, int], refine: bool) -> records.Grid:
    """Return the directions of all rays: the midpoints of an even grid over each beam."""
    (rays_high, rays_wide), units = footprint, beams.units
    start: dict[tuple[bytes, float], int] = {}  # first ray of each table, so that equal fans share one
    fan_ray, elevations, ranges, rays = [], [], [], 0
    for fan, u in enumerate(beams.fan_unit):
        elevation = _elevations(beams, fan, rays_high)
        key = (elevation.tobytes(), float(units.range_max[u]))
        if key not in start:
            start[key] = rays
            elevations.append(np.repeat(elevation, rays_wide))
            ranges.append(np.full(len(elevations[-1]), units.range_max[u]))
            rays += len(elevations[-1])
        fan_ray.append(start[key])
    elevation, turn = np.concatenate(elevations), units.beam_width[:, None] * np.tile(_midpoints(rays_wide), rays_high)
    return records.Grid(
        half_width=units.beam_width / 2.0,
        side=np.ascontiguousarray(_cos_sin(turn).transpose(0, 2, 1)),
        fan_ray=np.array(fan_ray),
        azimuth=_cos_sin(beams.azimuth),
        slope=elementwise.tan(elevation),
        cos=elementwise.cos(elevation),
        far=1.0 / (np.concatenate(ranges) * elementwise.cos(elevation)),
        refine=refine,
    )


def _elevations(beams: BeamTable, fan: int, rays_high: int) -> Floats:
    """Return the (K, L, I) elevations of the I rows of rays of the L beams at each of the K azimuths of a fan [rad]."""
    first, end = beams.row_beam[beams.fan_row[[fan, fan + 1]]]
    layers = beams.fan_row[fan + 1] - beams.fan_row[fan]
    centre: Floats = beams.elevation[first:end].reshape(layers, -1).T[:, :, None]
    elevation: Floats = centre + beams.units.beam_height[beams.fan_unit[fan]] * _midpoints(rays_high)
    return elevation


def _midpoints(count: int) -> Floats:
    """Return the (count,) midpoints of equal parts of [-1/2, 1/2]."""
    return (np.arange(count) + 0.5) / count - 0.5


def _cos_sin(angle: Floats) -> Floats:
    """Return (..., 2) cosine and sine of angles (...)."""
    return np.stack([elementwise.cos(angle), elementwise.sin(angle)], axis=-1)


def _solids(bodies: Bodies) -> records.Solids:
    return records.Solids(
        bodies.motion, bodies.bounds, bodies.body_solid, bodies.solid_plane, bodies.solid_bounds, bodies.solid_inner,
        bodies.planes, bodies.plane_reflectivity, bodies.plane_transmission,
    )  # fmt: skip


def _static_scene(walls: Walls, context: ScanContext) -> records.StaticScene:
    return records.StaticScene(
        walls.ends, walls.z, walls.reflectivity, GROUND_REFLECTIVITY, context.extinction, context.ground
    )


def displace(echoes: Echoes, bodies: Bodies, scale: float) -> Echoes:
    """Return the echoes moved to the relief of their surfaces.

    Parameters
    ----------
    echoes
        Echoes of the solids.
    scale
        Factor of the heights; 0 returns the echoes unchanged.
    """
    if scale == 0.0:
        return echoes
    ranges, points = echoes.range.copy(), echoes.point_body.copy()
    rough = RoughPlanes(
        bodies.planes_body, bodies.plane_turn, bodies.plane_relief, bodies.plane_pivot, bodies.relief_waves
    )
    shift_to_relief(echoes.target, echoes.surface, echoes.direction_body, rough, scale, ranges, points)
    return replace(echoes, range=ranges, point_body=points)
