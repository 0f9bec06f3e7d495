"""Ground truth of one scan, for oracles, which share it for the scan that the tracker sees."""

from dataclasses import dataclass
from typing import Any, TypeVar

import numpy as np

from luxloop.arrays import Bools, Floats, Ints
from luxloop.scenarios.grading.frame_truth import IS_VEHICLE, NO_ACTOR_ROW, Ownership, point_rows
from luxloop.scenarios.grading.grading_config import GradingConfig
from luxloop.scenarios.grading.plane_geometry import into_frame, out_of_frame, turned
from luxloop.sensor_model.truth import NO_ACTOR, Cause, ScanTruth
from luxloop.sim.sections import bend
from luxloop.sim.world import WorldFrame
from luxloop.tracker.records import Detection, Segments
from luxloop.tracker.tracking.track_table import TrackTable

OracleT = TypeVar("OracleT")
USUAL = GradingConfig()
"""Default limits of the grader, for the ownership of segments and the bend of articulated trucks."""


@dataclass(frozen=True, slots=True, eq=False)
class Truth:
    """Ground truth of a scan of N points with A actors; the last row, -1, of arrays by row means no actor."""

    actor_id: Ints
    """(A + 1,) id of each actor, and `NO_ACTOR`."""
    point_row: Ints
    """(N,) row of the actor each point lies on, -1 for none."""
    noise: Bools
    """(N,) mask of noise, which outlier removal should find."""
    boxes_ego: Floats
    """(A, 5) true boxes at the scan's time, ego frame."""
    velocity_ego: Floats
    """(A, 2) velocity over ground, in the axes of the ego frame [m/s]."""
    boxed: Bools
    """(A + 1,) mask of actors with a rectangular outline: vehicles other than articulated trucks in a bend."""
    vehicle_id: Ints
    """Ids of the vehicles among the actors."""
    mode: dict[int, int]
    """True `Mode` of each actor by its id."""

    @classmethod
    def of(cls, frame: WorldFrame, truth: ScanTruth) -> "Truth":
        """Return the ground truth of a frame."""
        actors, ego = frame.actors, frame.ego.pose_world
        vehicle = IS_VEHICLE[actors.kind]
        bent = bend(actors.joint_angles) > np.deg2rad(USUAL.bent_deg)
        return cls(
            actor_id=np.append(actors.id, NO_ACTOR),
            point_row=point_rows(truth.actor_id, actors.id),
            noise=truth.cause != Cause.CLEAN,
            boxes_ego=np.column_stack([into_frame(actors.pose_world, ego), actors.size[:, :2]]),
            velocity_ego=turned(actors.velocity_world, -ego[2]),
            boxed=np.append(vehicle & ~bent, False),
            vehicle_id=actors.id[vehicle],
            mode=dict(zip(actors.id.tolist(), actors.mode.tolist(), strict=True)),
        )

    def center_odom(self, actor_id: Ints, ego_pose_odom: Floats) -> Floats:
        """(T, 2) true box centres of actors (T,) in the odometry frame [m], NaN for actors that are not present."""
        center = np.full((len(self.actor_id), 2), np.nan)
        center[:-1] = out_of_frame(self.boxes_ego[:, :3], ego_pose_odom)[:, :2]
        return np.asarray(center[self._row_of(actor_id)])

    def size_of(self, actor_id: Ints) -> Floats:
        """(T, 2) true length and width of actors (T,) [m], NaN for those that are not present or have no rectangle."""
        size = np.full((len(self.actor_id), 2), np.nan)
        size[:-1][self.boxed[:-1]] = self.boxes_ego[self.boxed[:-1], 3:]
        return np.asarray(size[self._row_of(actor_id)])

    def _row_of(self, actor_id: Ints) -> Ints:
        """(T,) rows of actors (T,), -1 for those that are not present."""
        present = np.isin(actor_id, self.actor_id[:-1])
        return np.where(present, np.searchsorted(self.actor_id[:-1], actor_id), NO_ACTOR_ROW)

    def owner_row(self, segments: Segments) -> Ints:
        """(S,) row of the actor that owns most points of a segment, -1 for none."""
        eligible = np.ones(len(self.boxes_ego), dtype=np.bool_)
        return Ownership.of(self.point_row, segments, eligible, USUAL.owner_share_min).owner

    def boxed_owner(self, segments: Segments) -> Bools:
        """(S,) mask of segments whose owner has a rectangular outline."""
        return np.asarray(self.boxed[self.owner_row(segments)])

    def on_owner(self, segments: Segments) -> Bools:
        """(N,) mask of points on the owner of their segment."""
        owner = np.append(self.owner_row(segments), NO_ACTOR_ROW)[segments.label]  # points in no segment have label -1
        return np.asarray((owner != NO_ACTOR_ROW) & (owner == self.point_row))


class OracleContext:
    """Ground truth of the current scan, the boxes detected in it, and the actor that each track follows.

    A track follows the owner of its last box that has one.
    """

    truth: Truth
    """Ground truth of the current scan."""
    ego_pose_odom: Floats
    """(3,) ego pose of the last detected scan."""
    box_actor: Ints
    """(B,) actor that owns each detected box, `NO_ACTOR` for none."""
    support: Ints
    """(B,) points of each detected box."""

    def __init__(self) -> None:
        self._actor_of: dict[int, int] = {}
        """Actor by the id of the track that follows it."""

    def add_detection(self, ego_pose_odom: Floats, found: Detection) -> None:
        """Set the boxes detected in the current scan."""
        self.ego_pose_odom = ego_pose_odom
        self.support = found.boxes.support
        self.box_actor = self.truth.actor_id[self.truth.owner_row(found.segments)[found.boxes.segment]]

    def add_tracks(self, track_id: Ints) -> None:
        """Update the followed actors by the track (B,) of each box, negative for none."""
        owned = (track_id >= 0) & (self.box_actor != NO_ACTOR)
        self._actor_of.update(zip(track_id[owned].tolist(), self.box_actor[owned].tolist(), strict=True))

    def track_actor(self, tracks: TrackTable) -> Ints:
        """(T,) actor that each track follows, `NO_ACTOR` for none."""
        return np.array([self._actor_of.get(id, NO_ACTOR) for id in tracks.id.tolist()], dtype=np.int64)


def oracle_over(oracle: type[OracleT], shipped: type, real: object, **attributes: Any) -> OracleT:
    """Return an oracle over a real stage: it has the stage's state, and its methods where the oracle has none.

    Parameters
    ----------
    oracle
        Class derived from `shipped`.
    shipped
        Class of the shipped stage, from which the class of `real` is derived, too.
    attributes
        Further attributes of the oracle.
    """
    kind = type(real)
    mixed: Any = oracle if kind is shipped else type(f"{oracle.__name__}Over{kind.__name__}", (oracle, kind), {})
    found: OracleT = mixed.__new__(mixed)
    vars(found).update(vars(real), **attributes)
    return found
