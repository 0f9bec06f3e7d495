"""The sensor: a world frame goes in, a scan and its truth come out."""

import numpy as np
import numpy.typing as npt

from sensor_model.beams import beam_table
from sensor_model.bodies import Bodies, BodyShop
from sensor_model.cast import Caster, Hits
from sensor_model.draws import Draws
from sensor_model.noise import KEPT, NoiseConfig, lost_beams, measured_range
from sensor_model.odometry import Odometry
from sensor_model.rig import Rig
from sensor_model.truth import NO_ACTOR, Cause, ScanTruth
from sensor_model.visibility import point_causes, view_kind, visible_faces
from sensor_model.walls import walls_of
from sim.world import Actors, Obstacles, WorldFrame
from tracker.scan import Scan

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]


class Lidar:
    """All units of a rig, for one run.

    The sweep is frozen: every beam is fired at the frame's time, and `Scan.time_offset` is zero. A beam gives at most
    one echo, as wide as the unit's pulse. No flags are set: finding the ground is left to the tracker. Points come in
    the order of the beam table.

    Parameters
    ----------
    rig
        Which units sit where.
    noise
        Strength of each kind of noise.
    seed
        Of all random draws; same seed, same scans.
    obstacles
        Static things of the run, in the world frame.
    """

    def __init__(self, rig: Rig, noise: NoiseConfig, seed: int, obstacles: Obstacles) -> None:
        self.beams = beam_table(rig)
        self._noise = noise
        self._bodies = BodyShop(mirrors=noise.mirror.enabled, plain=not noise.layer_overlap.enabled)
        self._walls_world = walls_of(obstacles)
        self._caster = Caster(self.beams)
        self._draws = Draws(seed, self.beams)
        self._odometry = Odometry()

    def scan(self, frame: WorldFrame) -> tuple[Scan, ScanTruth]:
        """Sweep all units once over a frame of the world."""
        ego_pose, actors = frame.ego.pose_world, frame.actors
        bodies = self._bodies.place(actors, ego_pose)
        walls = self._walls_world.seen_from(ego_pose)
        hits = self._caster.cast(bodies, walls, actors.reflectivity)
        loss = lost_beams(hits, self.beams, self._noise.dropout, self._draws, frame.index)
        kept = np.flatnonzero(loss == KEPT)
        beam, true_range = hits.beam[kept], hits.range[kept]
        measured = measured_range(beam, true_range, self.beams, self._noise.range, self._draws, frame.index)
        scan = self._scan(frame.time, self._odometry.pose(ego_pose), beam, measured)
        return scan, self._truth(hits, loss, kept, bodies, actors)

    def _scan(self, time: float, ego_pose_odom: Floats, beam: Ints, measured: Floats) -> Scan:
        beams = self.beams
        unit = beams.unit[beam]
        points_ego = beams.origin_ego.take(unit, axis=0) + measured[:, None] * beams.direction_ego.take(beam, axis=0)
        return Scan(
            time=time,
            ego_pose_odom=ego_pose_odom,
            points_ego=points_ego.astype(np.float32),
            time_offset=np.zeros(len(beam), dtype=np.float32),
            unit=unit,
            layer=beams.layer[beam],
            echo=np.zeros(len(beam), dtype=np.uint8),
            echo_pulse_width=beams.pulse_length[beam].astype(np.float32),
            flags=np.zeros(len(beam), dtype=np.uint16),
        )

    def _truth(self, hits: Hits, loss: npt.NDArray[np.int8], kept: Ints, bodies: Bodies, actors: Actors) -> ScanTruth:
        actor_id = np.full(len(kept), NO_ACTOR, dtype=np.int64)
        cause = np.full(len(kept), Cause.CLEAN, dtype=np.uint8)
        on_actor = np.flatnonzero(hits.target[kept] >= 0)
        point = kept[on_actor]
        actor = hits.target[point]
        actor_id[on_actor] = actors.id[actor]
        cause[on_actor] = point_causes(hits.part[point], hits.point_body[point], actors.size[actor])

        on_outline = cause[on_actor] == Cause.CLEAN
        normal_body = bodies.planes[hits.surface[point[on_outline]], :3]
        faces = visible_faces(actor[on_outline], normal_body, len(actors))
        lost = np.flatnonzero(loss != KEPT)
        return ScanTruth(
            actor_id=actor_id,
            part=hits.part[kept],
            cause=cause,
            true_range=hits.range[kept].astype(np.float32),
            lost_unit=self.beams.unit[hits.beam[lost]],
            lost_beam=self.beams.index[hits.beam[lost]],
            lost_cause=loss[lost].astype(np.uint8),
            hits=np.bincount(hits.target[hits.target >= 0], minlength=len(actors)).astype(np.int32),
            hits_alone=hits.alone.astype(np.int32),
            faces=faces,
            view=view_kind(faces),
        )
