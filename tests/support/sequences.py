"""Random sequences in the format of trackeval."""

import numpy as np

FRAMES = 12


def random_sequence(seed, vehicles, tracks, empty=0.0, steps=20):
    """Vehicles and tracks that appear and disappear, with overlaps that often equal a threshold of HOTA.

    `empty` is the share of time steps without vehicles, and of those without tracks. Overlaps are multiples of
    1 / `steps`: few make ties.
    """
    rng = np.random.default_rng(seed)

    def subset(count):
        return np.flatnonzero(rng.random(count) < 0.7)

    gt, seen = [subset(vehicles) for _ in range(FRAMES)], [subset(tracks) for _ in range(FRAMES)]
    for ids in (gt, seen):
        for t in np.flatnonzero(rng.random(FRAMES) < empty):
            ids[t] = np.empty(0, np.int64)
    gt[0], seen[0] = np.arange(vehicles), np.arange(tracks)  # every id occurs, as in a run
    overlap = [np.round(rng.random((len(g), len(s))) * steps) / steps for g, s in zip(gt, seen, strict=True)]
    return {
        "num_timesteps": FRAMES,
        "num_gt_ids": vehicles,
        "num_tracker_ids": tracks,
        "num_gt_dets": sum(map(len, gt)),
        "num_tracker_dets": sum(map(len, seen)),
        "gt_ids": gt,
        "tracker_ids": seen,
        "similarity_scores": overlap,
    }
