"""Posterior probabilities of a vehicle's length and width, from the extents of its views and from vehicle classes.

Bayes' rule over a grid of sizes. Length and width of one class are independent; the class connects them, so that a wide
front belongs to a long vehicle.
"""

import numpy as np

from luxloop.tracker.arrays import Bools, Floats
from luxloop.tracker.tracking.kernels import size_posterior as kernel
from luxloop.tracker.tracking.kernels.size_likelihood import LOG_ODDS_MAX, add_view
from luxloop.tracker.tracking.vehicle_sizes import GRID_M


class SizePosterior:
    """Log-likelihoods and posterior probabilities of the sides of `GRID_M`, estimated from the first view on.

    Parameters
    ----------
    view_correlation
        Correlation of the views of one side, which is the minimum weight of a view.
    forgetting
        Share of the earlier evidence that a view of the whole side replaces.
    truncated, merged
        Probabilities that a side that seems whole is truncated, and that a view is merged with another object.
    hidden
        (2,) part of length and width that rounded corners hide [m].
    """

    def __init__(
        self, view_correlation: float, forgetting: float, truncated: float, merged: float, hidden: Floats
    ) -> None:
        self._settings, self._hidden = (view_correlation, forgetting, truncated, merged), hidden
        self._log_likelihood = np.zeros((2, len(GRID_M)))
        self._of_pieces = np.zeros((2, len(GRID_M)))
        """Mean log-likelihoods of the truncated views: all of them together have the evidence of one."""
        self._views = np.zeros((2, 2), dtype=np.int64)
        """Numbers of all views and of truncated ones, by side."""

    def observe(self, observed: Floats, whole: Bools, visible_min_m: float) -> None:
        """Add a view of extents (2,) [m], with a mask (2,) of sides truncated at neither end.

        A side that is visible over `visible_min_m` or less may face away.
        """
        self.size, self.std = kernel.observe(
            self._log_likelihood,
            self._of_pieces,
            self._views,
            observed,
            whole,
            visible_min_m,
            self._hidden,
            self._settings,
        )

    def exceed(self, extents: Floats) -> None:
        """Exclude sides shorter than extents (2,) [m], which other evidence than a single view shows."""
        _, _, truncated, merged = self._settings
        weight, cut = np.full(2, LOG_ODDS_MAX), np.zeros(2, np.bool_)
        add_view(self._log_likelihood, extents, cut, weight, np.zeros(2), self._hidden, truncated, merged)
        self._estimate()

    def turn(self, quarters: int) -> None:
        """Rename the sides for a heading turned by `quarters`."""
        if quarters % 2:
            self._log_likelihood, self._of_pieces = self._log_likelihood[::-1].copy(), self._of_pieces[::-1].copy()
            self._views = self._views[:, ::-1].copy()
            self._estimate()

    def _estimate(self) -> None:
        """Update length and width (2,), and their standard deviations (2,) [m]."""
        self.size, self.std = kernel.estimate(self._log_likelihood, self._of_pieces)
