"""Segmentation errors: split vehicles, merged objects, and missed vehicles."""

from typing import Any

import numpy as np
import numpy.typing as npt

from luxloop.scenarios.arrays import Bools, Floats, Ints
from luxloop.scenarios.grading.ownership import Ownership
from luxloop.sensor_model.truth import NO_ACTOR


def rows(actor_id: Ints, graded: Bools, ownership: Ownership, share_min: float) -> dict[str, npt.NDArray[Any]]:
    """Return the segments of one frame in which a graded vehicle has a share of at least `share_min`.

    Parameters
    ----------
    actor_id, graded
        (A,) ids of the actors, and True for the graded ones.
    """
    share = ownership.counts / np.maximum(ownership.size, 1)
    touched = (share[:-1][graded] >= share_min).any(axis=0)
    segment = np.flatnonzero(touched)
    share = share[:, segment]
    ranked = np.sort(share, axis=0)
    return {
        "segment": segment,
        "points": ownership.size[segment],
        "actor_id": np.append(actor_id, NO_ACTOR)[share.argmax(axis=0)],
        "share": ranked[-1],
        "second_share": ranked[-2] if len(actor_id) else ranked[-1],
    }


def actor_shares(ownership: Ownership, points: Ints, share_min: float) -> tuple[Ints, Floats]:
    """Return the number (A,) of segments with at least `share_min` of an actor's points, and the largest share (A,).

    Parameters
    ----------
    points
        (A,) number of points on each actor.
    """
    share = ownership.counts[:-1] / np.maximum(points, 1)[:, None]
    return (share >= share_min).sum(axis=1), share.max(axis=1, initial=0.0)
