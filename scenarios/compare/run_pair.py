"""Two runs of the same scenario and seed, and their resampling units."""

from dataclasses import dataclass

import numpy as np

from luxloop.scenarios.arrays import Floats, Ints
from luxloop.scenarios.compare.digest import Key, RunDigest
from luxloop.scenarios.compare.truth_sums import counterparts
from luxloop.sensor_model.truth import NO_ACTOR

SUMS_TOLERANCE = 2e-6
"""Relative difference of two sums that is none: another CPU and the rounding of the baseline change them by 1e-6."""


@dataclass(frozen=True, slots=True, eq=False)
class Pair:
    """Two runs that can be compared."""

    base: RunDigest
    head: RunDigest

    @property
    def key(self) -> Key:
        """Scenario and seed of both runs."""
        return self.base.key

    @property
    def identical(self) -> bool:
        """True if frames, scans and tracks are bit-identical, which only runs on one type of CPU can be."""
        return self.base.trace_hash == self.head.trace_hash

    @property
    def same(self) -> bool:
        """True if the truth and all sums are equal within the tolerances."""
        base, head = self.units()
        return self.same_truth and bool(np.array_equal(base, head))

    @property
    def same_truth(self) -> bool:
        """True if both trackers had the same traffic and points, within the tolerances."""
        base, head = self.base.vehicles, self.head.vehicles
        return len(base.vehicle) == len(head.vehicle) == len(self._counterparts()[0])

    @property
    def without_counterpart(self) -> int:
        """Number of vehicles of BASE or HEAD, whichever has more, without a counterpart on the other side."""
        vehicles = max(len(run.vehicles.vehicle) - 1 for run in (self.base, self.head))
        return vehicles - int((self.base.vehicles.vehicle[self._counterparts()[0]] != NO_ACTOR).sum())

    def units(self) -> tuple[Floats, Floats]:
        """Return the sums of BASE and of HEAD (U, len(COLUMNS)) of the U resampling units.

        A unit is a vehicle with the same truth on both sides. The last unit is everything else: false tracks, and
        vehicles without a counterpart, because traffic or points differ. Sums of HEAD within the tolerance of those of
        BASE are set equal to them: such differences come from another CPU, not from another tracker.
        """
        base, head = self.base.vehicles.columns(), self.head.vehicles.columns()
        own, others = self._counterparts()
        paired = self.base.vehicles.vehicle[own] != NO_ACTOR
        base, head = _units(base, own[paired]), _units(head, others[paired])
        return base, np.where(np.isclose(head, base, rtol=SUMS_TOLERANCE, atol=0.0), base, head)

    def _counterparts(self) -> tuple[Ints, Ints]:
        base, head = self.base.vehicles, self.head.vehicles
        return counterparts(base.vehicle, head.vehicle, base.truth, head.truth)


def _units(columns: Floats, paired: Ints) -> Floats:
    """Return the rows of the paired vehicles and the sum of all others."""
    return np.vstack([columns[paired], np.delete(columns, paired, axis=0).sum(axis=0)])
