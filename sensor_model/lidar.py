"""LIDAR simulation: from a world frame to a scan and its ground truth."""

import numpy as np
import numpy.typing as npt

from luxloop import elementary, elementwise
from luxloop.arrays import Floats, Ints
from luxloop.sensor_model.bodies.rotation import tilt_rotations
from luxloop.sensor_model.bodies.scene import Bodies, BodyFactory
from luxloop.sensor_model.bodies.walls import NearbyWalls, walls_of
from luxloop.sensor_model.clutter import ClutterSources
from luxloop.sensor_model.ground import UnevenGround
from luxloop.sensor_model.noise import fog, rain, snow
from luxloop.sensor_model.noise.attitude import Attitude
from luxloop.sensor_model.noise.calibration import doubled_points, sync_jitter, true_mounts
from luxloop.sensor_model.noise.detection import DetectionThresholds, loss_causes
from luxloop.sensor_model.noise.false_alarms import wrong_flags
from luxloop.sensor_model.noise.noise_config import NoiseConfig
from luxloop.sensor_model.noise.random_draws import Draws
from luxloop.sensor_model.noise.ranging import MeasuredRanges, echo_places, measure_ranges, measure_widths
from luxloop.sensor_model.noise.thresholds import Thresholds
from luxloop.sensor_model.odometry import Odometry
from luxloop.sensor_model.raycaster import Echoes, Raycaster, displace
from luxloop.sensor_model.returns import NOTHING, Returns
from luxloop.sensor_model.rig.beams import beam_table, sweep_limits
from luxloop.sensor_model.rig.rig import Rig
from luxloop.sensor_model.scan_context import ScanContext, displacement, over_ground
from luxloop.sensor_model.sensor_config import SensorConfig
from luxloop.sensor_model.truth import NO_ACTOR, Cause, Loss, Part, ScanTruth
from luxloop.sensor_model.visibility import from_surfaces, view_kind, visible_faces
from luxloop.sim.world import Obstacles, WorldFrame
from luxloop.tracker.scan import PointFlag, Scan


class Lidar:
    """LIDAR units of a rig, for one run.

    Every beam fires at its own time, the one along a unit's axis at the frame's time, while ego and actors move. Points
    are in the order of the beam table, from near to far. They are placed as by the rig's fusion box: along the nominal
    beam, in the ego frame at the time of firing (no deskew).

    Parameters
    ----------
    rig
        Units and their mounting poses.
    noise
        Strengths of all kinds of noise.
    sensor
        Sampling of the beams.
    seed
        Seed of all random draws; equal seeds give equal scans.
    obstacles
        Ground and static obstacles of the run, in the world frame.

    Raises
    ------
    ValueError
        The noise names a unit that the rig does not have.
    """

    def __init__(self, rig: Rig, noise: NoiseConfig, sensor: SensorConfig, seed: int, obstacles: Obstacles) -> None:
        self.beams = beam_table(rig)
        self._noise = noise
        self._extinction = rain.extinction(noise.rain) + snow.extinction(noise.snow) + fog.extinction(noise.fog)
        self._sweep = sensor.sweep
        self._relief_scale = sensor.relief_scale
        self._time_offset = self.beams.time_offset * sensor.sweep
        self._sweep_limits = sweep_limits(self.beams) if sensor.sweep else None
        self._unit_positions_ego = self.beams.units.origin_ego[:, :2].copy()
        self._draws = Draws(seed, self.beams)
        self._mounts = true_mounts(noise.calibration, self.beams.units, self._draws)
        self._attitude = Attitude(noise.attitude, self._draws)
        self._detection = DetectionThresholds(noise, self.beams, self._draws, [mount.name for mount in rig.mounts])
        plain = not noise.layer_overlap.enabled
        self._bodies = BodyFactory(mirrors=noise.mirror.enabled, plain=plain, glass=sensor.glass, seed=seed)
        self._walls = NearbyWalls(walls_of(obstacles))
        self._ground = UnevenGround(obstacles.terrain)
        self._caster = Raycaster(self.beams, sensor)
        self._clutter = ClutterSources(noise, self.beams, self._caster, self._draws)
        self._odometry = Odometry(noise.odometry, self._draws)

    def scan(self, frame: WorldFrame) -> tuple[Scan, ScanTruth]:
        """Simulate one scan of all units for a frame of the world."""
        thresholds = self._detection.thresholds(frame.index, frame.time, float(frame.ego.pose_world[2]))
        context = self._context(frame, thresholds)
        bodies = self._bodies.place(frame)
        walls = self._walls.seen_from(frame.ego.pose_world, self._caster.reach(context), frame.ego.ground_z)
        echoes = self._caster.cast(bodies, walls, context, free_range=self._clutter.needs_free_range)
        echoes = displace(echoes, bodies, self._relief_scale)
        returns = from_surfaces(echoes, bodies)
        returns = self._clutter.add(returns, echoes, bodies, walls, context, thresholds, frame)
        on_surface, place = returns.target != NOTHING, echo_places(returns.range)
        ranges = measure_ranges(
            returns.beam, returns.range, place, on_surface, self.beams, self._noise, self._draws, frame.index
        )
        return self._scan(frame, returns, place, ranges), self._truth(
            frame, echoes, returns, ranges, bodies, context, thresholds
        )

    def _context(self, frame: WorldFrame, thresholds: Thresholds) -> ScanContext:
        """Return the context of a scan: the body tilts, and the mounting poses have calibration errors."""
        R_level_body = self._attitude.at(frame.time, elementary.hypot(*frame.ego.velocity_world))
        if frame.ego.attitude.any():  # the noise is relative to the attitude of the world record
            R_level_body = elementwise.product(tilt_rotations(frame.ego.attitude[None])[0], R_level_body)
        origin_body, R_body_unit = self._mounts
        velocity, acceleration, yaw_rate = over_ground(frame.ego)
        return ScanContext(
            frame_index=frame.index,
            origin_ego=elementwise.product(origin_body, R_level_body.T),
            R_ego_unit=elementwise.product(R_level_body, R_body_unit),
            time_jitter=self._sync_jitter(frame.index),
            ego_velocity=velocity,
            ego_acceleration=acceleration,
            ego_yaw_rate=yaw_rate,
            threshold=thresholds.threshold,
            extinction=self._extinction,
            ground=self._ground.seen_from(frame.ego),
        )

    def _sync_jitter(self, frame: int) -> Floats:
        """Return the (U,) delay of the units' firing times relative to the reported ones [s]; 0 without a sweep."""
        if not self._sweep:
            return np.zeros(len(self.beams.units))
        return sync_jitter(self._noise.calibration, len(self.beams.units), frame, self._draws)

    def _scan(self, frame: WorldFrame, returns: Returns, place: Ints, ranges: MeasuredRanges) -> Scan:
        beams, beam, index = self.beams, returns.beam, frame.index
        unit = beams.unit.take(beam)
        points = beams.units.origin_ego.take(unit, axis=0)
        points += ranges.range[:, None] * beams.direction_ego.take(beam, axis=0)
        width = measure_widths(beam, place, returns.width, beams, self._noise, self._draws, index)
        return Scan(
            time=frame.time,
            ego_pose_odom=self._odometry.pose(frame.ego.pose_world, frame.time, frame.index),
            points_ego=points.astype(np.float32),
            time_offset=self._time_offset.take(beam).astype(np.float32),
            unit=unit,
            layer=beams.layer.take(beam),
            echo=returns.echo,
            echo_pulse_width=width.astype(np.float32),
            flags=returns.flags | returns.transparent | self._wrong_flags(returns, place, index),
            sweep_limits=self._sweep_limits,
            unit_positions_ego=self._unit_positions_ego,
        )

    def _wrong_flags(self, returns: Returns, place: Ints, frame: int) -> npt.NDArray[np.uint16]:
        """Return the (N,) `PointFlag.CLUTTER` of echoes that are not of droplets."""
        wrong = wrong_flags(self._noise.false_alarms, returns.beam, place, self._draws, frame)
        return np.where(wrong & (returns.part != Part.DROPLET), PointFlag.CLUTTER, 0).astype(np.uint16)

    def _truth(
        self, frame: WorldFrame, echoes: Echoes, returns: Returns, ranges: MeasuredRanges, bodies: Bodies,
        context: ScanContext, thresholds: Thresholds,
    ) -> ScanTruth:  # fmt: skip
        beams, actors = self.beams, frame.actors
        on_actor = np.flatnonzero(returns.target >= 0)
        actor_id = np.full(len(returns), NO_ACTOR, dtype=np.int64)
        actor_id[on_actor] = actors.id[returns.target[on_actor]]

        unit = beams.unit.take(returns.beam)
        faces = visible_faces(returns, unit, context.origin_ego, bodies, actors.size)
        cause = returns.cause.copy()
        if self._noise.calibration.enabled:
            moved = displacement(returns, beams, self._mounts, bodies, context)
            twice = doubled_points(self._noise.calibration, moved, unit, returns.target, len(actors))
            cause[twice & (cause == Cause.CLEAN)] = Cause.DOUBLED
        cause[ranges.outlier] = Cause.RANGE_OUTLIER
        dry_power = echoes.lost_power * elementwise.exp(2.0 * context.extinction * echoes.lost_range)
        lost_cause = loss_causes(thresholds, echoes.lost_beam, echoes.lost_power, dry_power)
        lost_cause[echoes.lost_range == 0.0] = Loss.TOO_NEAR
        return ScanTruth(
            actor_id=actor_id,
            part=returns.part,
            cause=cause,
            true_range=returns.range.astype(np.float32),
            lost_unit=beams.unit[echoes.lost_beam],
            lost_beam=beams.index[echoes.lost_beam],
            lost_cause=lost_cause,
            unit_hits=echoes.unit_hits,
            unit_hits_alone=echoes.unit_hits_alone,
            faces=faces,
            view=view_kind(faces),
        )
