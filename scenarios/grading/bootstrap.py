"""Bootstrap confidence intervals of averages over many frames of few vehicles.

Observations of one vehicle are correlated from frame to frame. Whole vehicles are therefore resampled, with all their
observations (cluster bootstrap: Davison and Hinkley 1997, Bootstrap Methods and their Application, section 3.8). Each
resample has as many vehicles as the run; the interval lies between two percentiles of the resamples.
"""

import numpy as np

from scenarios.arrays import Floats, Ints

RESAMPLES = 1000
SEED = 0
"""Fixed for reproducible intervals."""
QUANTILES = (0.025, 0.975)

Interval = tuple[float, float]


class Bootstrap:
    """Resamples of a run's vehicles, shared by all metrics.

    Parameters
    ----------
    vehicles
        Ids of all vehicles with observations, in any order, with or without repetitions.
    """

    def __init__(self, vehicles: Ints) -> None:
        self.vehicles = np.unique(vehicles)
        count = len(self.vehicles)
        rng = np.random.default_rng(SEED)
        drawn = rng.integers(max(count, 1), size=(RESAMPLES, count))
        cell = drawn + count * np.arange(RESAMPLES)[:, None]
        self.times = np.bincount(cell.ravel(), minlength=RESAMPLES * count).reshape(RESAMPLES, count).astype(np.float64)

    def of_ratio(self, vehicle: Ints, part: Floats, whole: Floats) -> Interval | None:
        """Return the interval of sum `part` (n,) over sum `whole` (n,), or None if all are of one `vehicle` (n,)."""
        sums = self._sums(vehicle, part, whole)
        return _interval(sums[:, 0], sums[:, 1]) if sums is not None else None

    def of_std(self, vehicle: Ints, values: Floats) -> Interval | None:
        """Return the interval of the standard deviation of `values` (n,), or None as for `of_ratio`."""
        sums = self._sums(vehicle, values, values**2, np.ones_like(values))
        if sums is None:
            return None
        total, squares, count = sums[sums[:, 2] > 0.0].T
        variance = squares / count - (total / count) ** 2
        return _interval(np.sqrt(np.maximum(variance, 0.0)), np.ones_like(count))

    def _sums(self, vehicle: Ints, *columns: Floats) -> Floats | None:
        """(RESAMPLES, columns) sums of each resample, computed from the sums of each vehicle."""
        if len(np.unique(vehicle)) < 2:
            return None
        row = np.searchsorted(self.vehicles, vehicle)
        own = np.stack([np.bincount(row, column, len(self.vehicles)) for column in columns], axis=1)
        sums: Floats = self.times @ own
        return sums


def _interval(part: Floats, whole: Floats) -> Interval:
    """Return percentiles of the ratio over the resamples with observations."""
    drawn = whole > 0.0
    return percentiles(part[drawn] / whole[drawn])


def percentiles(values: Floats) -> Interval:
    """Return the 95 % interval of the values (R,) of the resamples."""
    low, high = np.quantile(values, QUANTILES)
    return float(low), float(high)
