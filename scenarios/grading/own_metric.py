"""Metric of a scenario or study file: its definition, and the names that files may refer to."""

import re
from collections.abc import Iterable
from typing import Annotated, Self

from pydantic import BaseModel, ConfigDict, Field, model_validator

from luxloop.scenarios.grading.metric_definition import Definition
from luxloop.scenarios.grading.metric_names import GRADED, REGISTRY, TURNING
from luxloop.sim.world import Kind

PREFIX = "own."
"""Beginning of the names of own metrics in results, which no shipped metric has."""
NOT_BY_ACTOR = ("outliers.", "dataset.frames", "emergence.target.", "sim.")
"""Beginnings of the names of graded metrics that are not sums over actors."""

KINDS = tuple(kind.name.lower() for kind in Kind)
"""Classes of actors."""

Names = str | list[str]


class OwnMetric(BaseModel):
    """A metric of one's own: a shipped metric over some actors, or a function of the run's tables."""

    model_config = ConfigDict(
        extra="forbid",
        frozen=True,
        strict=True,
        allow_inf_nan=False,
        use_attribute_docstrings=True,
        populate_by_name=True,
    )

    name: str
    """Name in expectations, curves, searches and results; begins with `own.`."""
    of: str = ""
    """Shipped metric that is computed over the chosen actors only."""
    actor: Names = Field(default_factory=list)
    """Name of the actor, or list of names, that `of` is computed over."""
    of_class: Annotated[Names, Field(alias="class")] = Field(default_factory=list)
    """Class of the actors, such as `"truck"`, or list of classes; with `actor` the actors must be of both."""
    function: str = ""
    """`MODULE:FUNCTION` called with the run's tables, instead of `of`; it returns a number, or None without one."""
    unit: str = ""
    """Unit of the value of a function; default: `1`. Not used with `of`."""
    meaning: str = ""
    """Meaning in one line, for reports."""

    @property
    def actors(self) -> list[str]:
        """Names of the chosen actors; empty for all."""
        return [self.actor] if isinstance(self.actor, str) else self.actor

    @property
    def classes(self) -> list[str]:
        """Classes of the chosen actors; empty for all."""
        return [self.of_class] if isinstance(self.of_class, str) else self.of_class

    @property
    def definition(self) -> Definition:
        """Name, unit and meaning."""
        if self.function:
            return Definition(self.name, self.unit or "1", self.meaning or f"value of {self.function}")
        chosen = [f"actor {' or '.join(self.actors)}"] * bool(self.actors)
        chosen += [f"class {' or '.join(self.classes)}"] * bool(self.classes)
        meaning = self.meaning or f"{REGISTRY[self.of].meaning}; only {', '.join(chosen)}"
        return Definition(self.name, REGISTRY[self.of].unit, meaning)

    @model_validator(mode="after")
    def _is_consistent(self) -> Self:
        if not re.fullmatch(r"own\.\w+(\.\w+)*", self.name):
            raise ValueError(f'name = "{self.name}": should begin with own. and a word, as own.truck_hota')
        if bool(self.of) == bool(self.function):
            raise ValueError("give either of (a shipped metric) with actor or class, or function")
        if self.function:
            self._check_function()
        else:
            self._check_filter()
        return self

    def _check_function(self) -> None:
        if not re.fullmatch(r"[\w.]+:\w+", self.function):
            raise ValueError(f'function = "{self.function}": should be MODULE:FUNCTION')
        if self.actors or self.classes:
            raise ValueError("actor and class belong to of; a function chooses the rows of its tables itself")

    def _check_filter(self) -> None:
        if self.of not in (*GRADED, *TURNING) or self.of.startswith(NOT_BY_ACTOR):
            raise ValueError(f'of = "{self.of}": no metric of actors; name one of the graded metrics, as track.hota')
        if not (self.actors or self.classes):
            raise ValueError(f"give actor or class, or use {self.of} itself")
        if unknown := [name for name in self.classes if name not in KINDS]:
            raise ValueError(f'class = "{unknown[0]}": no class of actors; name one of {", ".join(KINDS)}')
        if self.unit:
            raise ValueError(f'unit = "{self.unit}": leave it out, the unit is that of {self.of}')


def definitions_of(metrics: Iterable[OwnMetric]) -> dict[str, Definition]:
    """Return the definitions by name.

    Raises
    ------
    ValueError
        A name is defined twice.
    """
    found: dict[str, Definition] = {}
    for metric in metrics:
        if metric.name in found:
            raise ValueError(f"{metric.name} is defined twice; give each metric a name of its own")
        found[metric.name] = metric.definition
    return found
