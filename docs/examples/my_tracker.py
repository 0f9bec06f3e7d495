"""Minimal example of a tracker: a patch of points is a car, and the nearest patch in the next scan is the same car.

luxloop run docs/examples/my-first.toml --tracker docs.examples.my_tracker:PatchTracker
"""

import numpy as np
import scipy

from luxloop.tracker.records import Tracks

CELL_M, RANGE_M, REACH_M = 0.5, 60.0, 1.5
CAR_M = np.array([4.6, 1.8])


class PatchTracker:
    """Boxes of a car's size with the heading of the ego; suitable for straight roads only."""

    def __init__(self, config):
        del config  # the scenario's [tracker] table: settings of the shipped tracker
        self.ids, self.centers, self.born = np.empty(0, int), np.empty((0, 2)), 0

    def step(self, scan):
        """Process one scan and return the tracks, in the odometry frame."""
        ids, centers = self.follow(scan.points_ego, scan.ego_pose_odom)
        return Tracks.from_boxes(ids, centers, scan.ego_pose_odom[2], CAR_M)

    def follow(self, points_ego, ego_pose_odom):
        """Return ids and centres of the cars in points (N, 3), in the odometry frame."""
        x, y, yaw = ego_pose_odom
        turn = np.array([[np.cos(yaw), -np.sin(yaw)], [np.sin(yaw), np.cos(yaw)]])
        centers = cars(points_ego) @ turn.T + (x, y)
        self.ids, self.centers = self.ids_of(centers), centers
        return self.ids, centers

    def ids_of(self, centers):
        """Return the ids of the nearest cars of the last scan, nearest pairs first, each used once, or new ids."""
        ids = np.zeros(len(centers), int)
        distance = np.linalg.norm(centers[:, None] - self.centers, axis=2)
        while distance.size and distance.min() < REACH_M:
            new, old = np.unravel_index(distance.argmin(), distance.shape)
            ids[new] = self.ids[old]
            distance[new], distance[:, old] = np.inf, np.inf
        for new in np.flatnonzero(ids == 0):
            self.born += 1
            ids[new] = self.born
        return ids


def cars(points_ego):
    """(T, 2) centres of car-sized patches in the ego frame [m]; the near edges are at the points."""
    points = points_ego[(points_ego[:, 2] > 0.2) & (np.abs(points_ego[:, :2]) < RANGE_M).all(axis=1), :2]
    cell = ((points + RANGE_M) / CELL_M).astype(int)
    grid = np.zeros((int(2 * RANGE_M / CELL_M),) * 2, bool)
    grid[cell[:, 0], cell[:, 1]] = True
    label = scipy.ndimage.label(grid, structure=np.ones((3, 3)))[0][cell[:, 0], cell[:, 1]]
    centers = []
    for patch in (points[label == k] for k in np.unique(label)):
        low, high = patch.min(axis=0), patch.max(axis=0)
        if len(patch) >= 10 and (high - low).max() < 8.0:
            middle = 0.5 * (low + high)
            centers.append(middle + np.sign(middle) * 0.5 * np.maximum(CAR_M - (high - low), 0.0))
    return np.reshape(centers, (-1, 2))
