"""J-linkage (Toldo and Fusiello, ECCV 2008): T-linkage with binary preferences."""

import numpy as np

from luxloop.tracker.arrays import Floats, Ints
from luxloop.tracker.detection.baselines.baseline_config import BaselineConfig
from luxloop.tracker.detection.baselines.principal_axes import direction
from luxloop.tracker.detection.baselines.ransac_lines import distances
from luxloop.tracker.detection.tlinkage import LinkageConfig, agglomerate, hypotheses, uniforms

SAMPLING = LinkageConfig()
"""Settings of the hypotheses, as for T-linkage."""


def heading(points_ego: Floats, config: BaselineConfig) -> float:
    """Direction of the line through the largest cluster of points (N, 2) [rad]."""
    cluster = clusters(points_ego, config)
    return direction(points_ego[cluster == np.bincount(cluster).argmax()])


def clusters(points: Floats, config: BaselineConfig) -> Ints:
    """(N,) cluster of each point, as the index of a member.

    For binary preferences the Tanimoto distance is the Jaccard distance and the elementwise minimum the intersection,
    so the merging of T-linkage is that of J-linkage.
    """
    draws = uniforms(config.seed, max(len(points), config.points_max), SAMPLING.samples_per_point)
    lines = hypotheses(points, draws, SAMPLING.locality)
    return agglomerate((distances(points, lines) < config.inlier_m).astype(np.float64))
