"""Model selection: how the filter bank of a track mixes and selects motion models."""

from collections.abc import Callable
from typing import Protocol

from luxloop.tracker.arrays import Floats
from luxloop.tracker.tracking.average_bank import AverageBank
from luxloop.tracker.tracking.filter_bank import FilterBank, SelectedBank
from luxloop.tracker.tracking.filters import FilterConfig, Filters, initial_filters
from luxloop.tracker.tracking.imm import FilterpyImm
from luxloop.tracker.tracking.mma import MmaConfig
from luxloop.tracker.tracking.paper_bank import PaperBank


class ModelSelection(Protocol):
    """Maker of filter banks. A bank mixes and selects the models of its own track."""

    def new_bank(self, position: Floats, covariance: Floats) -> FilterBank:
        """Return the filter bank of a track that starts at (2,) [m] with covariance (2, 2) [m^2]."""


BANKS: dict[str, Callable[[Filters, MmaConfig], FilterBank]] = {
    "mma": SelectedBank,
    "imm": FilterpyImm,
    "average": AverageBank,
    "paper": PaperBank,
}
"""Filter bank of each `MmaConfig.method`."""


class BankSelection:
    """Model selection by `MmaConfig.method`."""

    def __init__(self, filters: FilterConfig, mma: MmaConfig) -> None:
        self._filters = filters
        self._mma = mma

    def new_bank(self, position: Floats, covariance: Floats) -> FilterBank:
        """Return the filter bank of a track that starts at (2,) [m] with covariance (2, 2) [m^2]."""
        return BANKS[self._mma.method](initial_filters(position, covariance, self._filters), self._mma)
