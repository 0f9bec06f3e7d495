"""Model selection: how the filter bank of a track mixes and selects motion models."""

from typing import Protocol

from tracker.arrays import Floats
from tracker.tracking.filter_bank import FilterBank, SelectedBank
from tracker.tracking.filters import FilterConfig, initial_filters
from tracker.tracking.imm import FilterpyImm
from tracker.tracking.mma import MmaConfig


class ModelSelection(Protocol):
    """Maker of filter banks. A bank mixes and selects the models of its own track."""

    def new_bank(self, position: Floats, covariance: Floats) -> FilterBank:
        """Return the filter bank of a track that starts at (2,) [m] with covariance (2, 2) [m^2]."""


class BankSelection:
    """Model selection by `MmaConfig.method`: multiple-model association, the paper's or filterpy's IMM."""

    def __init__(self, filters: FilterConfig, mma: MmaConfig) -> None:
        self._filters = filters
        self._mma = mma

    def new_bank(self, position: Floats, covariance: Floats) -> FilterBank:
        """Return the filter bank of a track that starts at (2,) [m] with covariance (2, 2) [m^2]."""
        filters = initial_filters(position, covariance, self._filters)
        return FilterpyImm(filters, self._mma) if self._mma.method == "imm" else SelectedBank(filters, self._mma)
