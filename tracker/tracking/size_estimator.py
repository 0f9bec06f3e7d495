"""Size of one tracked vehicle."""

import numpy as np

from luxloop.tracker.arrays import Bools, Floats, Ints
from luxloop.tracker.tracking import extent, orientation
from luxloop.tracker.tracking.extent import ExtentConfig
from luxloop.tracker.tracking.kernels import seen_extents
from luxloop.tracker.tracking.size_posterior import SizePosterior


class SizeEstimator:
    """Length and width of a vehicle, from its first view of extents (2,) [m] and mask `whole` (2,) on."""

    def __init__(self, first: Floats, whole: Bools, config: ExtentConfig) -> None:
        self._config = config
        self.whole_views: Ints = np.zeros(2, dtype=np.int64)
        """(2,) numbers of views of length and width from end to end."""
        self._posterior = SizePosterior(
            config.view_correlation,
            config.forgetting,
            config.truncated_probability,
            config.merged_probability,
            np.array([config.hidden_length_m, config.hidden_width_m]),
        )
        self.seen = first
        """(2,) seen length and width [m]."""
        self._posterior.observe(first, whole, config.face_min_m)

    @property
    def size(self) -> Floats:
        """(2,) length and width [m], unseen parts from priors."""
        return self._posterior.size

    @property
    def std(self) -> Floats:
        """(2,) standard deviations of length and width [m]."""
        return self._posterior.std

    @property
    def known(self) -> Floats:
        """(2,) part of length and width that is known to exist, from the tracked corner on [m]."""
        return extent.known(self.seen, self.size, self._config)

    def observe(self, observed: Floats, whole: Bools) -> None:
        """Update by observed extents (2,) [m], with a mask (2,) of those truncated at neither end."""
        config = self._config
        gains, growth = (config.growth, config.settled), (config.grown_min_m, config.large_length_min_m)
        limits = gains, config.face_min_m, growth
        self.seen = seen_extents.observe(self.seen, self.whole_views, observed, whole, *limits)
        self._posterior.observe(observed, whole, config.face_min_m)

    def extend(self, seen: Floats) -> None:
        """Set the seen extents (2,) [m] to those of several pieces together."""
        self.seen = seen
        self._posterior.exceed(seen)

    def turn(self, quarters: int) -> None:
        """Rename the sides for a heading turned by `quarters`."""
        self.whole_views = self.whole_views[:: -1 if quarters % 2 else 1].copy()
        self._posterior.turn(quarters)
        self.seen = orientation.turn_size(self.seen, quarters)
