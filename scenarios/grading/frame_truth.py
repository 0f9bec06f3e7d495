"""Ground truth of one frame for the grader: its actors, the actors of its points, and the owners of segments."""

from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt

from luxloop.arrays import Bools, Floats, Ints
from luxloop.scenarios.grading.articulated import ARTICULATION, section_boxes
from luxloop.scenarios.grading.grading_config import GradingConfig
from luxloop.scenarios.grading.plane_geometry import into_frame, iou_table
from luxloop.scenarios.grading.truth_events.event_log import FrameEvents
from luxloop.scenarios.grading.truth_events.truth_event import TruthEvent
from luxloop.scenarios.metrics.definitions import GROUPS
from luxloop.sensor_model.truth import NO_ACTOR, ON_NOTHING, Cause, ScanTruth
from luxloop.sim.sections import bend
from luxloop.sim.world import VEHICLE_KINDS, Actors, Kind, WorldFrame
from luxloop.tracker.records import Segments
from luxloop.tracker.scan import Scan

NO_ACTOR_ROW = -1
"""Actor row of points on no actor, and of segments without an owner."""


def point_rows(point_actor: Ints, actor_id: Ints) -> Ints:
    """Return the row (N,) of each point's actor (N,) in `actor_id` (A,), which is sorted; else `NO_ACTOR_ROW`."""
    row = np.full(len(point_actor), NO_ACTOR_ROW, dtype=np.int64)
    on_actor = np.flatnonzero(point_actor != NO_ACTOR)
    row[on_actor] = np.searchsorted(actor_id, point_actor[on_actor])
    return row


def points_of_actors(point_actor: Ints, actor_id: Ints) -> Ints:
    """(A,) number of points on each actor, of the actors (N,) of all points."""
    ids, count = np.unique(point_actor, return_counts=True)
    number = dict(zip(ids.tolist(), count.tolist(), strict=True))
    return np.array([number.get(actor, 0) for actor in actor_id.tolist()], np.int64)


@dataclass(frozen=True, slots=True, eq=False)
class Ownership:
    """Point counts of one frame by actor (A) and segment (S), and the owner of each segment."""

    counts: Ints
    """(A + 1, S) points of each actor in each segment; the last row counts points on no actor."""
    size: Ints
    """(S,) points in each segment."""
    owner: Ints
    """(S,) row of the graded vehicle with most points of the segment, or `NO_ACTOR_ROW`."""

    @classmethod
    def of(cls, row: Ints, segments: Segments, graded: Bools, share_min: float) -> "Ownership":
        """Count points and find the owners.

        Parameters
        ----------
        row
            (N,) actor row of each point.
        segments
            Labels of the same points.
        graded
            (A,) graded actors, the possible owners.
        share_min
            An owner has a larger share of the segment's points.
        """
        shape = (len(graded) + 1, segments.count)
        used = np.flatnonzero(segments.label >= 0)
        # NO_ACTOR_ROW, -1, becomes the last row of the table.
        cell = (row[used] % shape[0]) * segments.count + segments.label[used]
        counts = np.bincount(cell, minlength=shape[0] * shape[1]).reshape(shape)
        size = counts.sum(axis=0)
        holder = counts.argmax(axis=0)
        most = counts[holder, np.arange(segments.count)] > share_min * size
        owned = most & np.append(graded, False)[holder]
        return cls(counts, size, np.where(owned, holder, NO_ACTOR_ROW))


IS_VEHICLE = np.array([kind in VEHICLE_KINDS for kind in Kind])
"""True for vehicles, by `Kind`."""
IS_VULNERABLE = np.array([kind.name.lower() in GROUPS.values() for kind in Kind])
"""True for people and riders of bicycles, by `Kind`."""
IS_ON_NOTHING = np.isin(np.arange(len(Cause)), ON_NOTHING)
"""True for causes of points on no object, by `Cause`."""


@dataclass(frozen=True, slots=True, eq=False)
class FrameTruth:
    """Ground truth of one frame with N points and A actors."""

    frame: WorldFrame
    scan: Scan
    truth: ScanTruth
    boxes_ego: Floats
    """(A, 5) true boxes in the ego frame: x [m], y [m], yaw [rad], length [m], width [m]."""
    range_m: Floats
    """(A,) distance from the ego's centre to the actor's [m]."""
    point_row: Ints
    """(N,) row of the actor that each point lies on, -1 for none."""
    points: Ints
    """(A,) number of points on the actor."""
    bent: Bools
    """(A,) the actor is bent too much for one rectangle: an articulated truck or bus, a tram, a train."""
    graded: Bools
    """(A,) the actor is a vehicle in range, with enough points, and not masked."""
    vulnerable: Bools
    """(A,) the actor is a person or rider in range, with enough points, and not masked."""
    masked: Bools
    """(A,) the actor would be graded but for a truth event, see `FrameEvents.masked`."""
    ghosts_ego: Floats
    """(G, 5) boxes in the ego frame of actors that vanished in view shortly before."""

    @property
    def boxed(self) -> Bools:
        """(A,) the actor is graded, and one rectangle describes it: fits and poses are graded, too."""
        return self.graded & ~self.bent

    @property
    def actors(self) -> Actors:
        """The frame's actors."""
        return self.frame.actors

    @classmethod
    def of(
        cls,
        frame: WorldFrame,
        scan: Scan,
        truth: ScanTruth,
        config: GradingConfig,
        events: FrameEvents | None = None,
    ) -> "FrameTruth":
        """Evaluate the truth of one frame with the limits of `config`, and with its events, if they are known."""
        actors = frame.actors
        pose_ego = into_frame(actors.pose_world, frame.ego.pose_world)
        range_m = np.hypot(pose_ego[:, 0], pose_ego[:, 1])
        row = point_rows(truth.actor_id, actors.id)
        points = np.bincount(row[row >= 0], minlength=len(actors))
        bent = bend(actors.joint_angles) > np.deg2rad(config.bent_deg)
        gradable = IS_VEHICLE[actors.kind] & (range_m <= config.range_max_m) & (points >= config.points_min)
        masked = np.zeros(len(actors), np.bool_) if events is None else events.masked
        near = (range_m <= config.vulnerable_range_max_m) & (points >= config.vulnerable_points_min)
        ghosts = np.empty((0, 5)) if events is None else events.ghosts_world
        return cls(
            frame=frame,
            scan=scan,
            truth=truth,
            boxes_ego=np.column_stack([pose_ego, actors.size[:, :2]]),
            range_m=range_m,
            point_row=row,
            points=points,
            bent=bent,
            graded=gradable & ~masked,
            vulnerable=IS_VULNERABLE[actors.kind] & near & ~masked,
            masked=gradable & masked,
            ghosts_ego=np.hstack([into_frame(ghosts[:, :3], frame.ego.pose_world), ghosts[:, 3:]]),
        )

    def overlap(self, boxes_ego: Floats) -> Floats:
        """(A, T) intersection over union with boxes (T, 5) in the ego frame.

        A bent vehicle has the largest overlap of its straight box and of its sections. A track on the tractor alone
        thus follows the truck, and a truck keeps its track while it bends.
        """
        table = iou_table(self.boxes_ego, boxes_ego)
        bent = np.flatnonzero(self.bent)
        if not len(bent):
            return table
        pose, size = np.split(self.boxes_ego[bent], [3], axis=1)
        row, _, poses, sizes = section_boxes(pose, size, self.actors.joint_angles[bent], self.actors.kind[bent])
        np.maximum.at(table, bent[row], iou_table(np.hstack([poses, sizes]), boxes_ego))
        return table

    def rows(self, track_id: Ints, segments: Ints, largest_share: Floats) -> dict[str, npt.NDArray[Any]]:
        """Return the rows of the truth table.

        Parameters
        ----------
        track_id
            (A,) id of the track that follows each actor.
        segments, largest_share
            (A,) number of segments of each actor, and the largest share of its points in one segment.
        """
        actors, truth = self.actors, self.truth
        x, y, yaw = actors.pose_world.T
        return {
            "actor_id": actors.id,
            "name": actors.name,
            "kind": actors.kind,
            "x_world_m": x,
            "y_world_m": y,
            "yaw_world_rad": yaw,
            "length_m": actors.size[:, 0],
            "width_m": actors.size[:, 1],
            **dict(zip(ARTICULATION, actors.joint_angles.T, strict=True)),
            "vx_world_mps": actors.velocity_world[:, 0],
            "vy_world_mps": actors.velocity_world[:, 1],
            "ax_world_mps2": actors.acceleration_world[:, 0],
            "ay_world_mps2": actors.acceleration_world[:, 1],
            "yaw_rate_radps": actors.yaw_rate,
            "mode": actors.mode,
            "deviation_along_m": actors.deviation[:, 0],
            "deviation_across_m": actors.deviation[:, 1],
            "changes_lane": actors.changes_lane,
            "range_m": self.range_m,
            "points": self.points,
            "hits": truth.hits,
            "hits_alone": truth.hits_alone,
            "visible_fraction": truth.visible_fraction,
            "view": truth.view,
            "graded": self.graded,
            "vulnerable": self.vulnerable,
            "track_id": track_id,
            "segments": segments,
            "largest_segment_share": largest_share,
        }


@dataclass(frozen=True, slots=True, eq=False)
class FrameGrade:
    """Grade of one frame with A actors, T tracks and B boxes. Unassigned tracks and boxes have `NO_ACTOR` and NaN."""

    graded: Bools
    """(A,) the actor is a vehicle in range, with enough points on it, and not a bent truck."""
    points: Ints
    """(A,) scan points that lie on the actor."""
    track_actor: Ints
    """(T,) id of the actor that each track follows."""
    track_heading_error: Floats
    """(T,) heading of the track minus truth, modulo a full turn, in (-pi, pi] [rad]."""
    box_actor: Ints
    """(B,) id of the graded actor with most points of the box's segment."""
    box_heading_error: Floats
    """(B,) heading of the box minus truth, modulo a quarter turn, in (-pi/4, pi/4] [rad]."""
    events: list[TruthEvent] = field(default_factory=list)
    """Events of the ground truth that begin in this frame."""
