"""Update of all tracks: the filters of all banks are scored and corrected as one batch of arrays."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from luxloop.tracker.arrays import Floats
from luxloop.tracker.tracking import corner_error
from luxloop.tracker.tracking.corner_estimator import CornerEstimator
from luxloop.tracker.tracking.filter_bank import ScoredFilters
from luxloop.tracker.tracking.filters import Filters, stacked
from luxloop.tracker.tracking.independent_filters import IndependentFilters
from luxloop.tracker.tracking.kernels import filter_banks as kernel
from luxloop.tracker.tracking.track import Track
from luxloop.tracker.tracking.track_observation import TrackObservation


class Update(NamedTuple):
    """Update of one corner."""

    corner: CornerEstimator
    bank: ScoredFilters
    """The bank of the corner."""
    seen: TrackObservation
    heading: float
    """[rad]."""


def update(tracks: Sequence[Track], seen: Sequence[TrackObservation]) -> None:
    """Update each track by its observation; the same as `Track.update` of each."""
    admitted = [track.admit(one) for track, one in zip(tracks, seen, strict=True)]
    observe_corners([track.corner for track in tracks], admitted, [track.heading for track in tracks])
    for track, one in zip(tracks, admitted, strict=True):
        track.follow(one)


def observe_corners(
    corners: Sequence[CornerEstimator], seen: Sequence[TrackObservation], headings: Sequence[float]
) -> None:
    """Update the corners of T tracks with headings [rad] by one observation each.

    Banks with the update of `ScoredFilters` form a batch for each setting of the scores; others are updated one by one.
    """
    batches: dict[tuple[float, float], list[Update]] = {}
    for corner, one, heading in zip(corners, seen, headings, strict=True):
        bank = corner.bank
        if isinstance(bank, ScoredFilters) and type(bank).observe is ScoredFilters.observe:
            batches.setdefault((bank.tail_dof, bank.floor), []).append(Update(corner, bank, one, heading))
        else:
            corner.observe(one, heading)
    for settings, batch in batches.items():
        _observe_together(batch, *settings)


def _observe_together(updates: Sequence[Update], tail_dof: float, floor: float) -> None:
    """Update corners whose banks have equal settings, in the order of `CornerEstimator.observe`."""
    corners, banks, seen, headings = zip(*updates, strict=True)
    misfit, noise = np.array([one.misfit for one in seen]), np.array([one.covariance for one in seen])
    selected = np.arange(len(updates)), [bank.model for bank in banks]
    measured = np.array([corner.selected for corner in corners]) + misfit[selected]
    errors = np.array([corner.error.variance for corner in corners]), np.array([one.exact for one in seen])
    heading = np.array(headings)
    released = corner_error.released(*errors, noise, heading)
    noise = _observe_banks(banks, misfit, noise, released, (tail_dof, floor))
    observed = corner_error.observe(*errors, noise, heading, corners[0].error.least)
    for corner, variance in zip(corners, observed, strict=True):
        corner.error.variance = variance
    _observe_independent([corner.independent for corner in corners], measured, noise, released)


def _observe_banks(
    banks: Sequence[ScoredFilters], residual: Floats, noise: Floats, released: Floats, settings: tuple[float, float]
) -> Floats:
    """Score and correct T banks by residuals (T, M, 2) [m]; return the covariance (T, 2, 2) of the updates [m^2].

    `noise` (T, 2, 2) is that of the measurements, and `released` (T, 2, 2) is added to the positions before [m^2].
    `settings` are the degrees of freedom of the score and the lower limit of a probability.
    """
    states = *stacked([bank.filters for bank in banks]), np.array([bank.probability for bank in banks])
    *corrected, used = kernel.observe(*states, residual, noise, released, *settings)
    for bank, mean, covariance, own in zip(banks, *corrected, strict=True):
        bank.filters, bank.probability = Filters(mean, covariance), own
    return np.asarray(used)


def _observe_independent(
    independent: Sequence[IndependentFilters], measured: Floats, noise: Floats, released: Floats
) -> None:
    """Correct the independent filters of T tracks by corners (T, 2) [m] with covariance `noise` (T, 2, 2) [m^2]."""
    states = stacked([own.filters for own in independent])
    corrected = kernel.observe_independent(*states, measured, noise, released)
    for own, mean, covariance, nis in zip(independent, *corrected, strict=True):
        own.filters, own.nis = Filters(mean, covariance), nis
