"""Reference implementations of the kernels of detection on points and their groups, in plain numpy."""

import numpy as np


def by_group(label, count):
    """Points of each group in their order, and the starts of the groups."""
    groups = [np.flatnonzero(label == g) for g in range(count)]
    return np.concatenate([*groups, np.empty(0, int)]), np.cumsum([0, *(len(group) for group in groups)])


def means(points, label, count):
    """Mean of each group."""
    return np.array([points[label == g].mean(axis=0) for g in range(count)])


def extents_along(points, label, count, directions):
    """Extent of each group along each direction."""
    return np.array([np.ptp(points[label == g] @ directions.T, axis=0) for g in range(count)])


def kept_points(points, time, flags, drop, range_max, half_size):
    """Mask of the points to keep."""
    finite = np.isfinite(points).all(axis=1) & np.isfinite(time)
    near = np.linalg.norm(points[:, :2], axis=1) <= range_max
    on_ego = (np.abs(points[:, :2]) <= half_size).all(axis=1)
    return finite & (flags & drop == 0) & near & ~on_ego


def box_points(points, on_line, truncated, time, viewpoint, members, center, heading, size, cut_margin):
    """Support, time, cut ends, viewpoint and extent of one box with the points `members`."""
    turn = np.array([[np.cos(heading), np.sin(heading)], [-np.sin(heading), np.cos(heading)]])
    place, lines = (points[members] - center) @ turn.T, on_line[members]
    at_end = place[lines & truncated[members]]
    cut = [(sign * at_end >= 0.5 * size - cut_margin).any(axis=0) for sign in (-1, 1)]
    return (
        lines.sum(),
        time[members][lines].mean() if lines.any() else 0.0,
        np.array(cut).T,
        viewpoint[members].mean(axis=0),
        np.ptp(place, axis=0),
    )


def truncated_points(channel, time, range_m, label, limits, neighbour_s, nearer_m):
    """Mask of points at truncated ends: every point against every other of its channel."""
    cut = np.zeros(len(channel), dtype=bool)
    for i in range(len(channel)):
        same = np.flatnonzero(channel == channel[i])
        if len(limits):
            first, last = limits[channel[i]]
            cut[i] = time[i] - first <= neighbour_s or last - time[i] <= neighbour_s
        else:
            cut[i] = time[i] in (time[same].min(), time[same].max())
        beside = [
            time[same][time[same] < time[i]].max(initial=-np.inf),
            time[same][time[same] > time[i]].min(initial=np.inf),
        ]
        for j in same[np.isin(time[same], beside) & (np.abs(time[same] - time[i]) <= neighbour_s)]:
            cut[i] |= label[i] != label[j] and range_m[i] - range_m[j] > nearer_m
    return cut
