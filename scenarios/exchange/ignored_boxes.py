"""True boxes that are neither right nor wrong, because the sensor hardly saw them or they are far away."""

import numpy as np
import scipy

from luxloop.scenarios.arrays import Bools, Floats, Ints
from luxloop.scenarios.errors import TracksError
from luxloop.scenarios.exchange.box_grading import BoxLimits
from luxloop.scenarios.exchange.box_table import BoxTable
from luxloop.scenarios.exchange.paired_frames import FramePairs, pair_frames
from luxloop.scenarios.grading.id_switches import ROUNDING
from luxloop.scenarios.grading.plane_geometry import iou_table


def leave_out(pairs: FramePairs, limits: BoxLimits) -> FramePairs:
    """Return the pairs without true boxes outside the limits, and without the tracks on them.

    Tracks are matched with all true boxes of a frame by the largest sum of overlaps; those matched with a box that is
    left out are left out, too, as distractors are in the benchmarks of KITTI and MOTChallenge (trackeval's
    preprocessing). So are tracks beyond the range that match no box.

    Parameters
    ----------
    pairs
        All boxes; with a limit of range, in axes about the ego.
    limits
        Limits of points, range and occlusion, and the least overlap of a match.

    Raises
    ------
    TracksError
        The truth has no numbers of points or levels of occlusion, which a limit needs.
    """
    if not limits.points_min and limits.range_max_m is None and limits.occluded_max is None:
        return pairs
    ignored = outside(pairs.truth, limits)
    far = _beyond(pairs.tracks, limits.range_max_m)
    kept = np.ones(len(pairs.tracks), np.bool_)
    for true, tracked in pairs.steps():
        overlap = iou_table(pairs.truth.boxes[true], pairs.tracks.boxes[tracked])
        row, column = _matched(overlap, limits.hit_iou_min)
        single = np.delete(tracked, column)
        kept[tracked[column[ignored[true[row]]]]] = False
        kept[single[far[single]]] = False
    return pair_frames(pairs.truth.select(~ignored), pairs.tracks.select(kept))


def outside(truth: BoxTable, limits: BoxLimits) -> Bools:
    """(N,) True for true boxes outside a limit.

    Raises
    ------
    TracksError
        As for `leave_out`.
    """
    ignored = _beyond(truth, limits.range_max_m)
    if limits.points_min:
        if truth.points is None:
            raise TracksError(f"{truth.source}: has no numbers of points; leave --points-min out")
        ignored |= truth.points < limits.points_min
    if limits.occluded_max is not None:
        if truth.occluded is None:
            raise TracksError(f"{truth.source}: has no levels of occlusion, as KITTI has; leave --occluded-max out")
        ignored |= truth.occluded > limits.occluded_max
    return ignored


def _beyond(table: BoxTable, range_max_m: float | None) -> Bools:
    """(N,) True for centres beyond a distance from the origin; none without a limit."""
    found: Bools = np.hypot(table.boxes[:, 0], table.boxes[:, 1]) > (np.inf if range_max_m is None else range_max_m)
    return found


def _matched(overlap: Floats, hit_iou_min: float) -> tuple[Ints, Ints]:
    """Return rows and columns of the matches in an overlap table (t, k)."""
    score = np.where(overlap < hit_iou_min - ROUNDING, 0.0, overlap)
    row, column = scipy.optimize.linear_sum_assignment(score, maximize=True)
    hit = score[row, column] > 0.0
    return row[hit], column[hit]
