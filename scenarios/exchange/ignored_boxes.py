"""True boxes that are neither right nor wrong, because the sensor hardly saw them."""

import numpy as np
import scipy

from scenarios.arrays import Bools, Floats, Ints
from scenarios.errors import TracksError
from scenarios.exchange.paired_frames import FramePairs, pair_frames
from scenarios.grading.id_switches import ROUNDING
from scenarios.grading.plane_geometry import iou_table


def leave_out(pairs: FramePairs, points_min: int, hit_iou_min: float) -> FramePairs:
    """Return the pairs without true boxes of fewer points, and without the tracks on them.

    Tracks are matched with all true boxes of a frame by the largest sum of overlaps; those matched with a box that is
    left out are left out, too, as distractors are in the benchmarks of KITTI and MOTChallenge (trackeval's
    preprocessing).

    Parameters
    ----------
    pairs
        All boxes.
    points_min
        Least number of LIDAR points on a box that counts.
    hit_iou_min
        Least overlap of a match.

    Raises
    ------
    TracksError
        The truth has no numbers of points.
    """
    if pairs.truth.points is None:
        raise TracksError(f"{pairs.truth.source}: has no numbers of points; leave --points-min out")
    ignored = pairs.truth.points < points_min
    kept = np.ones(len(pairs.tracks), np.bool_)
    for true, tracked in pairs.steps():
        overlap = iou_table(pairs.truth.boxes[true], pairs.tracks.boxes[tracked])
        kept[tracked[_on(overlap, ignored[true], hit_iou_min)]] = False
    return pair_frames(pairs.truth.select(~ignored), pairs.tracks.select(kept))


def _on(overlap: Floats, ignored: Bools, hit_iou_min: float) -> Ints:
    """Return the columns of an overlap table (t, k) that are matched with ignored rows (t,)."""
    score = np.where(overlap < hit_iou_min - ROUNDING, 0.0, overlap)
    row, column = scipy.optimize.linear_sum_assignment(score, maximize=True)
    return np.asarray(column[(score[row, column] > 0.0) & ignored[row]])
