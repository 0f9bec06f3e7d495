"""The shipped tracker with an association of its own: the cost of a pair is the distance of the centres, up to 2 m.

luxloop run docs/examples/my-first.toml --tracker docs/examples/distance_score.py:tracker
luxloop blame docs/examples/my-first.toml --tracker docs/examples/distance_score.py:tracker
"""

import numpy as np

from luxloop.tracker.tracker import Tracker
from luxloop.tracker.tracking.association import HungarianAssociator

GATE_M = 2.0


class DistanceScore:
    """Costs and gate by the distance of the centres; heading, size and covariance do not count."""

    def __call__(self, tracks, predictions, hypotheses, observations):
        """Return the costs (T, B) of all pairs of track and box [m], and a mask (T, B) of those in the gate."""
        del tracks, hypotheses
        centers = predictions.selected - predictions.to_corner
        cost = np.linalg.norm(centers[:, None] - observations.center, axis=2)
        return cost, cost < GATE_M


def tracker(config):
    """Return the shipped tracker with this association."""
    return Tracker(config, associator=HungarianAssociator(config.association, DistanceScore()))
