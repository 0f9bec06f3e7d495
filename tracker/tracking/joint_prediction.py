"""Prediction of all tracks: the filters of all banks move on as one batch of arrays."""

from collections.abc import Sequence

import numpy as np

from luxloop.tracker.arrays import Floats
from luxloop.tracker.tracking import mma
from luxloop.tracker.tracking.filter_bank import FilterBank, SelectedBank
from luxloop.tracker.tracking.filters import Filters, Motion, stacked
from luxloop.tracker.tracking.independent_filters import IndependentFilters
from luxloop.tracker.tracking.kernels import filter_banks as kernel
from luxloop.tracker.tracking.mma import MmaConfig
from luxloop.tracker.tracking.track import Track


def predict(tracks: Sequence[Track], motion: Motion) -> None:
    """Move tracks on by one time step; the same as `Track.predict` of each."""
    if not tracks:
        return
    own, of_banks = zip(*(track.advance(motion) for track in tracks), strict=True)
    predict_independent([track.corner.independent for track in tracks], own)
    predict_banks([track.corner.bank for track in tracks], of_banks)


def predict_independent(independent: Sequence[IndependentFilters], motions: Sequence[Motion]) -> None:
    """Move the independent filters of T tracks on by one time step, each by its own motion."""
    moved, spread = kernel.move(*stacked([own.filters for own in independent]), *stacked_step(motions))
    unseen = np.full(moved.shape[:2], np.nan)
    for own, mean, covariance, nis in zip(independent, moved, spread, unseen, strict=True):
        own.filters, own.nis = Filters(mean, covariance), nis


def predict_banks(banks: Sequence[FilterBank], motions: Sequence[Motion]) -> None:
    """Move the filter banks of tracks on by one time step, each by its own motion.

    Banks with the prediction of `SelectedBank` form a batch for each configuration; others move on one by one.
    """
    together: list[tuple[SelectedBank, Motion]] = []
    for bank, motion in zip(banks, motions, strict=True):
        if isinstance(bank, SelectedBank) and type(bank).predict is SelectedBank.predict:
            together.append((bank, motion))
        else:
            bank.predict(motion)
    for config in {bank.config for bank, _ in together}:
        _predict_together([pair for pair in together if pair[0].config == config], config)


def _predict_together(pairs: Sequence[tuple[SelectedBank, Motion]], config: MmaConfig) -> None:
    """Mix the filters of each bank and move them on by its motion, in one batch."""
    banks, motions = [bank for bank, _ in pairs], [motion for _, motion in pairs]
    states = *stacked([bank.filters for bank in banks]), np.array([bank.probability for bank in banks])
    changes = mma.changes(motions[0].dt, config, motions[0].names)
    moved = kernel.predict(*states, *stacked_step(motions), changes)
    for bank, mean, covariance, own in zip(banks, *moved, strict=True):
        bank.filters, bank.probability = Filters(mean, covariance), own


def stacked_step(motions: Sequence[Motion]) -> tuple[Floats, Floats]:
    """Return transitions and noise of the M filters of T motions, (T * M, n, n), or (M, n, n) if all are the same."""
    first = motions[0]
    if all(motion is first for motion in motions):
        return first.models.transition, first.models.noise
    transition = np.concatenate([motion.models.transition for motion in motions])
    return transition, np.concatenate([motion.models.noise for motion in motions])
