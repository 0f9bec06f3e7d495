"""Ranges that are simply wrong."""

from dataclasses import dataclass

import numpy as np

from sensor_model.arrays import Bools, Floats, Ints
from sensor_model.noise.random_draws import Draws, Purpose


@dataclass(frozen=True, slots=True)
class Outliers:
    """Points on a surface with a gross range error, as from a distorted or saturated pulse."""

    enabled: bool = False
    """If not, all errors are ordinary."""
    rate: float = 0.002
    """Share of the echoes; an estimate."""
    scale_m: float = 1.0
    """[m] Mean size of the error, which is as often too near as too far: a Laplace distribution; an estimate, near the
    pulse's length, so that most outliers stay with their vehicle."""

    def __post_init__(self) -> None:
        if not 0.0 <= self.rate <= 1.0:
            raise ValueError(f"rate = {self.rate}: must be from 0 to 1")
        if not 0.0 < self.scale_m <= 50.0:
            raise ValueError(f"scale_m = {self.scale_m}: must be above 0 and at most 50; use rate = 0 for no outliers")


def gross_error(config: Outliers, beam: Ints, place: Ints, draws: Draws, frame: int) -> tuple[Floats, Bools]:
    """(N,) error of each echo [m], zero for most, and (N,) which are outliers.

    `place` (N,) tells the echoes of a beam apart.
    """
    by_chance, where = draws.uniform(frame, beam, Purpose.OUTLIER, place)
    outlier = by_chance < config.rate
    side = where[outlier] - 0.5
    error = np.zeros(len(beam))
    error[outlier] = -config.scale_m * np.sign(side) * np.log1p(-2.0 * np.abs(side))
    return error, outlier
