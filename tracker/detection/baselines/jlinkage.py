"""J-linkage (Toldo and Fusiello, ECCV 2008), which T-linkage relaxes: a point is near a line, or it is not."""

import numpy as np

from tracker.arrays import Floats, Ints
from tracker.detection.baselines.baseline_config import BaselineConfig
from tracker.detection.baselines.principal_axes import direction
from tracker.detection.baselines.ransac_lines import distances
from tracker.detection.kernels.linkage import agglomerate, hypotheses
from tracker.detection.tlinkage import LinkageConfig, uniforms

SAMPLING = LinkageConfig()
"""Hypotheses are drawn as T-linkage draws its own."""


def heading(points_ego: Floats, config: BaselineConfig) -> float:
    """Direction of the line through the largest cluster of points (N, 2) [rad]."""
    cluster = clusters(points_ego, config)
    return direction(points_ego[cluster == np.bincount(cluster).argmax()])


def clusters(points: Floats, config: BaselineConfig) -> Ints:
    """(N,) cluster of each point, named by a member.

    Of preferences that are 0 or 1 the Tanimoto distance is the Jaccard distance, and the elementwise minimum the
    intersection: T-linkage's merging does J-linkage's.
    """
    draws = uniforms(config.seed, max(len(points), config.points_max), SAMPLING.samples_per_point)
    lines = hypotheses(points, draws, SAMPLING.locality)
    return agglomerate((distances(points, lines) < config.inlier_m).astype(np.float64))
