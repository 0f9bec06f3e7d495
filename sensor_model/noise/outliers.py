"""Range outliers."""

from dataclasses import dataclass

import numpy as np

from luxloop import elementwise
from luxloop.arrays import Bools, Floats, Ints
from luxloop.sensor_model.noise.random_draws import Draws, Purpose


@dataclass(frozen=True, slots=True)
class Outliers:
    """Gross range errors of points on surfaces, such as from a distorted or saturated pulse."""

    enabled: bool = False
    """If false, there are no outliers."""
    rate: float = 0.002
    """Share of the echoes that are outliers; an estimate."""
    scale_m: float = 1.0
    """[m] Mean absolute error of a symmetric Laplace distribution; an estimate, close to the pulse length, so that most
    outliers stay with their vehicle."""

    def __post_init__(self) -> None:
        if not 0.0 <= self.rate <= 1.0:
            raise ValueError(f"rate = {self.rate}: must be from 0 to 1")
        if not 0.0 < self.scale_m <= 50.0:
            raise ValueError(f"scale_m = {self.scale_m}: must be above 0 and at most 50; use rate = 0 for no outliers")


def gross_error(config: Outliers, beam: Ints, place: Ints, draws: Draws, frame: int) -> tuple[Floats, Bools]:
    """Return the (N,) gross error of each echo [m], 0 for inliers, and the (N,) mask of outliers.

    `place` (N,) distinguishes the echoes of a beam.
    """
    by_chance, where = draws.uniform(frame, beam, Purpose.OUTLIER, place)
    outlier = by_chance < config.rate
    side = where[outlier] - 0.5
    error = np.zeros(len(beam))
    error[outlier] = -config.scale_m * np.sign(side) * elementwise.log1p(-2.0 * np.abs(side))
    return error, outlier
