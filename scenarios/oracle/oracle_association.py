"""The truth for association: a box goes to a track of the actor that it is of, without a gate about the prediction.

A new actor gets a track. Where an actor is seen in pieces, they and their tracks are matched by the real stage, and
made one by the real union; tracks of different actors are neither united nor exclude each other. What is left of an
actor's tracks keeps the id of the first. For how long a track waits is no matter of association (`[tracker.life]`): an
actor whose tracks have died is a new one. Boxes of nobody, such as walls, are for tracks of nobody, by the real stage.

The gate also guards against boxes that are misread: a rear that is taken for a front is a car's length off. So does the
truth: out of the gate a box is left alone if it would take its track away from the vehicle.
"""

import numpy as np

from scenarios.arrays import Bools, Floats, Ints
from sensor_model.truth import NO_ACTOR
from tracker.records import Status
from tracker.tracking.hypotheses import Hypotheses, Predictions
from tracker.tracking.track import Track

AWAY_M = 0.5
"""By so much a right box may take a track away from its vehicle [m]: corners are rounded, and sizes are guessed."""


def admissible(track_actor: Ints, box_actor: Ints, in_gate: Bools, misread: Bools) -> Bools:
    """(T, B) whether a track may have a box, by the actors (T,) and (B,) of both.

    Of an actor's tracks those that have the box `in_gate` (T, B) may have it; if none has, all that do not `misread` it
    (T, B).
    """
    same = track_actor[:, None] == box_actor
    out_of_all_gates = ~(same & in_gate).any(axis=0) & (box_actor != NO_ACTOR)
    return np.asarray(same & (in_gate | (out_of_all_gates & ~misread)))


def leads_away(predictions: Predictions, pairing: Hypotheses, true_center: Floats) -> Bools:
    """(T, B) whether a box would take a track away from where its vehicle is, (T, 2) in the odometry frame [m]."""
    each, model = np.arange(len(true_center)), predictions.probability.argmax(axis=1)
    off = predictions.selected - predictions.to_corner - true_center
    off_by_box = off[:, None] + pairing.misfit[each, :, model]
    return np.asarray(np.linalg.norm(off_by_box, axis=2) > np.linalg.norm(off, axis=1)[:, None] + AWAY_M)


def newcomers(box_actor: Ints, support: Ints, followed: Ints, free: Bools) -> Bools:
    """(B,) whether a box starts a track: the largest of each actor not `followed` yet, and those that are `free`.

    Parameters
    ----------
    box_actor
        (B,) actor of each box, `NO_ACTOR` for nobody's.
    support
        (B,) points of each box.
    followed
        Ids of actors that have a track.
    free
        (B,) whether the real stage would start one.
    """
    largest_first = np.argsort(-support, kind="stable")
    _, first = np.unique(box_actor[largest_first], return_index=True)
    largest = np.isin(np.arange(len(box_actor)), largest_first[first])
    return np.asarray(free | (largest & (box_actor != NO_ACTOR) & ~np.isin(box_actor, followed)))


def hand_over_id(tracks: list[Track]) -> None:
    """Let the oldest id among the tracks of one actor go on, if the track that bears it has just died."""
    living = [track for track in tracks if track.status is not Status.DEAD]
    if living:
        first, heir = min(tracks, key=lambda track: track.id), max(living, key=lambda track: track.hits)
        if first.status is Status.DEAD:
            first.id, heir.id = heir.id, first.id
