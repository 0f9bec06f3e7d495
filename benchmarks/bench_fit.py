"""Time of T-linkage for a car of 150 points."""

import time
from typing import Any

import numpy as np

from luxloop.tracker.detection.lidar import LidarConfig
from luxloop.tracker.detection.segmentation import sort_by_segment
from luxloop.tracker.detection.tlinkage import LinkageConfig, link
from luxloop.tracker.records import Segments

POINTS = 150
REPEATS = 300


def car_points() -> np.ndarray:
    """Return noisy points on the rear and the left side of a car 12 m ahead, and three on its mirror."""
    rng = np.random.default_rng(0)
    rear = np.stack([np.full(45, 12.0), np.linspace(-4.0, -2.2, 45)], axis=1)
    side = np.stack([np.linspace(12.0, 16.7, 102), np.full(102, -2.2)], axis=1)
    mirror = np.array([[15.0, -2.0], [15.0, -2.05], [15.05, -2.0]])
    points = np.concatenate([rear, side, mirror])
    return points + rng.normal(0.0, 0.025, points.shape)


def rows() -> dict[str, dict[str, Any]]:
    points = sort_by_segment(car_points(), Segments(label=np.zeros(POINTS, dtype=np.int64), count=1))
    config, lidar = LinkageConfig(), LidarConfig()
    link(points, config, lidar)
    spent = []
    for _ in range(REPEATS):
        start = time.perf_counter()
        link(points, config, lidar)
        spent.append(time.perf_counter() - start)
    value = 1e3 * float(np.median(spent))
    return {"tracker.tlinkage_150pt_ms": {"value": value, "unit": "ms", "peer": None, "ratio": None}}
