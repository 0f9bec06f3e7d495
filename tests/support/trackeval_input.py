"""Input of trackeval's metrics from boxes, with overlaps that shapely computes, and its names of the metrics."""

import numpy as np
from shapely import affinity
from shapely.geometry import box as rectangle

FIELDS = {
    "hota": "HOTA", "deta": "DetA", "assa": "AssA", "loca": "LocA", "mota": "MOTA", "motp": "MOTP", "idf1": "IDF1",
    "id_switches": "IDSW", "fragments": "Frag", "missed": "CLR_FN", "false": "CLR_FP",
}  # fmt: skip


def polygon(box):
    half = rectangle(-0.5 * box.length, -0.5 * box.width, 0.5 * box.length, 0.5 * box.width)
    return affinity.translate(affinity.rotate(half, box.heading, origin=(0, 0), use_radians=True), box.x, box.y)


def overlap(a, b):
    a, b = polygon(a), polygon(b)
    return a.intersection(b).area / a.union(b).area


def trackeval_sequence(truth, tracks):
    """Input of trackeval, made box by box."""
    ids = [sorted({b.id for b in boxes}) for boxes in (truth, tracks)]
    steps = [[[b for b in boxes if b.frame == frame] for boxes in (truth, tracks)] for frame in range(12)]
    return {
        "num_timesteps": len(steps),
        "num_gt_ids": len(ids[0]), "num_tracker_ids": len(ids[1]),
        "num_gt_dets": len(truth), "num_tracker_dets": len(tracks),
        "gt_ids": [np.array([ids[0].index(b.id) for b in step[0]], int) for step in steps],
        "tracker_ids": [np.array([ids[1].index(b.id) for b in step[1]], int) for step in steps],
        "similarity_scores": [
            np.array([[overlap(a, b) for b in step[1]] for a in step[0]]).reshape(len(step[0]), len(step[1]))
            for step in steps
        ],
    }  # fmt: skip
