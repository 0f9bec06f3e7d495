"""Settings that the baselines share."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class BaselineConfig:
    """Whether the baselines are fitted, and their scale."""

    enabled: bool = False
    """Fit them, to be graded beside the tracker's own methods; they are never selected."""
    inlier_m: float = 0.08
    """Points so near a line are on it, for RANSAC and J-linkage [m]: tau of T-linkage, three standard deviations."""
    points_max: int = 100
    """Larger segments are judged on an even subset: J-linkage's time grows with the cube of the points."""
    seed: int = 0
    """Of the random samples; every segment draws the same, so that its heading depends on its own points only."""

    def __post_init__(self) -> None:
        if self.inlier_m <= 0.0:
            raise ValueError(f"inlier_m is {self.inlier_m}; give a positive distance in metres")
        if not 2 <= self.points_max <= 10_000:
            raise ValueError(f"points_max is {self.points_max}; give 2, which a direction needs, to 10000")
        if self.seed < 0:
            raise ValueError(f"seed is {self.seed}; give 0 or more")
