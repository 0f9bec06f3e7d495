"""State that the oracles of one tracker share."""

import numpy as np

from luxloop.scenarios.arrays import Floats, Ints
from luxloop.scenarios.oracle.oracle_truth import Truth
from luxloop.sensor_model.truth import NO_ACTOR
from luxloop.tracker.records import Detection
from luxloop.tracker.tracking.track_table import TrackTable


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
