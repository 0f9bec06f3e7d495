"""A figure of real beside simulated vehicles, with its verdict."""

from typing import Literal, NamedTuple

from luxloop.scenarios.realism.compared_figures import Figure
from luxloop.scenarios.realism.weighted_average import Summary

Verdict = Literal["agrees", "differs", "n/a"]


class ComparedRow(NamedTuple):
    """A figure of real and of simulated vehicles."""

    figure: Figure
    real: Summary | None
    simulated: Summary | None

    @property
    def verdict(self) -> Verdict:
        """Verdict by the figure's tolerance and the real quartiles."""
        if self.real is None or self.simulated is None:
            return "n/a"
        value, (low, high) = self.simulated.value, self.real.quartiles
        near = abs(value - self.real.value) <= self.figure.tolerance * abs(self.real.value)
        return "agrees" if near or (self.figure.by_quartiles and low <= value <= high) else "differs"
