"""Rules of the tracking benchmark of KITTI, which compares boxes in the image, as trackeval's `Kitti2DBox`.

Of one class, these are neither right nor wrong: objects of a similar class, occluded and truncated objects, tracks on
them, and tracks on no object that are low or mostly inside a region without labels.
"""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from luxloop.scenarios.arrays import Bools, Floats
from luxloop.scenarios.errors import TracksError
from luxloop.scenarios.exchange.box_table import BoxTable
from luxloop.scenarios.exchange.paired_frames import BoxLimits, FramePairs, matched
from luxloop.scenarios.grading.plane_geometry import iou_table

SIMILAR: Mapping[str, str] = {"car": "van", "pedestrian": "person"}
"""Classes of the benchmark, and the similar class of each."""
REGION = "dontcare"
OCCLUDED_MAX, TRUNCATED_MAX = 2, 0
"""Highest levels of graded objects."""
LOWEST_PX = 25.0
"""[pixels] Tracks on no object that are at most as high are left out."""
INSIDE_MIN = 0.5
"""Tracks on no object are left out if a larger fraction of them is inside a region."""


def of_class(truth: BoxTable, tracks: BoxTable, name: str) -> tuple[BoxTable, BoxTable]:
    """Return the boxes that the rules of a class need: regions and both classes of the truth, one of the tracks."""
    assert truth.kind is not None
    if name not in SIMILAR:
        raise TracksError(f"--kitti {name}: no class of KITTI's benchmark; give one of {', '.join(SIMILAR)}")
    # Tracks of a file of labels have levels of occlusion and truncation, too; they do not count.
    tracks = replace(tracks, occluded=None, truncated=None)
    return truth.select(np.isin(truth.kind, [name, SIMILAR[name], REGION])), tracks.select(
        np.asarray(tracks.kind == name)
    )


def left_out(pairs: FramePairs, limits: BoxLimits) -> tuple[Bools, Bools]:
    """Return masks of the true boxes (N,) and of the tracks (M,) that are neither right nor wrong."""
    truth, tracks = pairs.truth, pairs.tracks
    assert truth.occluded is not None
    assert truth.truncated is not None
    region = np.asarray(truth.kind == REGION)
    ignored = np.asarray(truth.kind != limits.kitti)
    ignored |= (truth.occluded > OCCLUDED_MAX) | (truth.truncated > TRUNCATED_MAX)
    of_tracks = np.zeros(len(tracks), np.bool_)
    for true, tracked in pairs.steps():
        objects, regions = true[~region[true]], true[region[true]]
        row, column = matched(iou_table(truth.boxes[objects], tracks.boxes[tracked]), limits.hit_iou_min)
        single = np.delete(tracked, column)
        is_inside = (_inside(tracks.boxes[single], truth.boxes[regions]) > INSIDE_MIN).any(axis=1)
        of_tracks[tracked[column[ignored[objects[row]]]]] = True
        of_tracks[single[is_inside | (tracks.boxes[single, 4] <= LOWEST_PX)]] = True
    return ignored, of_tracks


def _inside(boxes: Floats, regions: Floats) -> Floats:
    """(k, r) fraction of each box in the image that is inside each region."""
    centre, half = boxes[:, None, :2], 0.5 * boxes[:, None, 3:]
    low = np.maximum(centre - half, regions[:, :2] - 0.5 * regions[:, 3:])
    high = np.minimum(centre + half, regions[:, :2] + 0.5 * regions[:, 3:])
    shared: Floats = np.maximum(high - low, 0.0).prod(axis=2) / boxes[:, None, 3:].prod(axis=2)
    return shared
