"""Tracker `patches`: a patch of points is a car, and the nearest patch in the next scan is the same car."""

import numpy as np
import scipy

from luxloop.tracker.records import Tracks
from luxloop.tracker.scan import Scan
from luxloop.tracker.tracker import TrackerConfig

CELL_M, RANGE_M, REACH_M, POINTS = 0.5, 60.0, 1.5, 10
CAR_M = np.array([4.6, 1.8])


class PatchTracker:
    """Nearest patch of points, without a filter."""

    def __init__(self, config: TrackerConfig) -> None:
        del config  # settings of the shipped tracker
        self.id, self.center, self.born = np.empty(0, np.int64), np.empty((0, 2)), 0

    def step(self, scan: Scan) -> Tracks:
        """Process one scan and return the tracks, in the odometry frame."""
        x, y, yaw = scan.ego_pose_odom
        turn = np.array([[np.cos(yaw), -np.sin(yaw)], [np.sin(yaw), np.cos(yaw)]])
        center = patches(scan.points_ego) @ turn.T + (x, y)
        distance = np.linalg.norm(center[:, None] - self.center, axis=2)
        new, old = scipy.optimize.linear_sum_assignment(distance)
        same = distance[new, old] < REACH_M
        ids = self.born + 1 + np.arange(len(center))
        ids[new[same]] = self.id[old[same]]
        self.id, self.center, self.born = ids, center, self.born + len(center)
        return Tracks.from_boxes(ids, center, yaw, CAR_M)


def patches(points_ego: np.ndarray) -> np.ndarray:
    """(T, 2) centres of patches of points in the ego frame [m]."""
    points = points_ego[(points_ego[:, 2] > 0.2) & (np.abs(points_ego[:, :2]) < RANGE_M).all(axis=1), :2]
    cell = ((points + RANGE_M) / CELL_M).astype(int)
    grid = np.zeros((int(2 * RANGE_M / CELL_M),) * 2, bool)
    grid[cell[:, 0], cell[:, 1]] = True
    label = scipy.ndimage.label(grid, structure=np.ones((3, 3)))[0][cell[:, 0], cell[:, 1]]
    found = [points[label == number] for number in np.unique(label)]
    centers = [0.5 * (patch.min(axis=0) + patch.max(axis=0)) for patch in found if len(patch) >= POINTS]
    return np.reshape(centers, (-1, 2))
