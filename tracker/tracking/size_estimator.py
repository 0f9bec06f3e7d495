"""Size of one tracked vehicle."""

import numpy as np

from tracker.arrays import Bools, Floats
from tracker.tracking import extent, orientation
from tracker.tracking.extent import ExtentConfig


class SizeEstimator:
    """Length and width of a vehicle: extents seen so far, completed by class priors.

    Methods take `oriented_hits`, the number of observations since the direction of motion confirmed the heading.
    """

    def __init__(self, first: Floats, config: ExtentConfig) -> None:
        self._config = config
        self._whole_views = np.zeros(2, dtype=np.int64)
        self.resize(first, oriented_hits=0)

    @property
    def seen_whole(self) -> Bools:
        """(2,) mask of length and width that were seen from end to end at least once."""
        return np.asarray(self._whole_views > 0)

    @property
    def known(self) -> Floats:
        """(2,) part of length and width that is known to exist, from the tracked corner on [m]."""
        return extent.known(self.seen, self.size, self._config)

    def observe(self, observed: Floats, whole: Bools, oriented_hits: int) -> None:
        """Update by observed extents (2,) [m], with a mask (2,) of those truncated at neither end."""
        # A side that grows to at most a car's length was not whole before: earlier views do not slow its growth down.
        grown = (observed > self.seen + self._config.grown_min_m) & (observed < self._config.large_length_min_m)
        views = np.where(grown, 0, self._whole_views)
        seen = extent.remember(self.seen, observed, whole, views, self._config)
        self._whole_views += extent.seen_whole(observed, whole, self._config)
        self.resize(seen, oriented_hits)

    def resize(self, seen: Floats, oriented_hits: int) -> None:
        """Set the seen extents (2,) [m] and complete them by priors."""
        self.seen = seen
        """(2,) seen length and width [m]."""
        usual = extent.classify(seen, self._whole_views, oriented_hits, self._config)
        self.size = extent.complete(seen, self._whole_views, usual, self._config)
        """(2,) length and width, unseen parts from priors [m]."""

    def turn(self, quarters: int, oriented_hits: int) -> None:
        """Rename the sides for a heading turned by `quarters`."""
        self._whole_views = self._whole_views[:: -1 if quarters % 2 else 1].copy()
        self.resize(orientation.turn_size(self.seen, quarters), oriented_hits)
