"""Settings that the baselines share."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class BaselineConfig:
    """Switch and parameters of the baselines."""

    enabled: bool = False
    """Fit the baselines, to be graded beside the tracker's own methods; they are never selected."""
    inlier_m: float = 0.08
    """Inlier threshold of RANSAC and J-linkage [m]: tau of T-linkage."""
    points_max: int = 100
    """Larger segments are reduced to an even subset: the time of J-linkage grows with the cube of the points."""
    seed: int = 0
    """Seed of the random samples, the same for every segment, so that segments do not affect each other."""

    def __post_init__(self) -> None:
        if self.inlier_m <= 0.0:
            raise ValueError(f"inlier_m is {self.inlier_m}; give a positive distance in metres")
        if not 2 <= self.points_max <= 10_000:
            raise ValueError(f"points_max is {self.points_max}; give 2 to 10000; a direction needs 2 points")
        if self.seed < 0:
            raise ValueError(f"seed is {self.seed}; give 0 or more")
