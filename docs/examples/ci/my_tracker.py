"""Nearest-neighbour tracker: a cluster of points is a car, and the nearest track of the last scan gives its id."""

import numpy as np
from scipy.cluster.hierarchy import fclusterdata

from luxloop.tracker.records import Tracks

GAP_M, REACH_M, RANGE_M, CAR_M = 0.9, 2.5, 50.0, np.array([4.5, 1.8])


class Nearest:
    """Tracks with a smoothed velocity; those of one scan are kept until the next."""

    def __init__(self, _config):
        self.id, self.at, self.v, self.time, self.born = np.empty(0, int), np.empty((0, 2)), np.empty((0, 2)), 0.0, 0

    def step(self, scan):
        """Return the tracks of a scan, in the odometry frame."""
        x, y, yaw = scan.ego_pose_odom
        turn = np.array([[np.cos(yaw), -np.sin(yaw)], [np.sin(yaw), np.cos(yaw)]])
        at, dt = cars(scan.points_ego) @ turn.T + (x, y), scan.time - self.time
        away = np.linalg.norm(at[:, None] - (self.at + dt * self.v), axis=2)
        ids, v = self.born + 1 + np.arange(len(at)), np.full_like(at, np.nan)
        while away.size and away.min() < REACH_M:
            new, old = np.unravel_index(away.argmin(), away.shape)
            ids[new], v[new] = self.id[old], 0.7 * self.v[old] + 0.3 * (at[new] - self.at[old]) / dt
            away[new], away[:, old] = np.inf, np.inf
        self.id, self.at, self.v, self.time, self.born = ids, at, np.nan_to_num(v), scan.time, self.born + len(at)
        heading = np.where(np.hypot(*self.v.T) > 3.0, np.arctan2(self.v[:, 1], self.v[:, 0]), yaw)
        return Tracks.from_boxes(ids, at, heading, CAR_M, velocity=v)


def cars(points):
    """(T, 2) centres of clusters of a car's size, in the ego frame [m]; their far sides are hidden."""
    near = points[(points[:, 2] > 0.3) & (np.hypot(points[:, 0], points[:, 1]) < RANGE_M), :2].astype(float)
    label = fclusterdata(near, GAP_M, criterion="distance") if len(near) > 1 else np.zeros(len(near))
    clusters = [near[label == k] for k in np.unique(label) if (label == k).sum() >= 10]
    low, high = (np.reshape([edge(cluster, axis=0) for cluster in clusters], (-1, 2)) for edge in (np.min, np.max))
    centers = 0.5 * (low + high + np.sign(low + high) * np.maximum(CAR_M - (high - low), 0.0))
    return centers[(high - low).max(axis=1) < 7.0]
