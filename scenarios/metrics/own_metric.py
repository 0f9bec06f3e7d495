"""Metric of a scenario or study file: its definition, and the names that files may refer to."""

import re
from collections.abc import Iterable
from dataclasses import replace
from typing import Annotated, Self

from pydantic import BaseModel, ConfigDict, Field, model_validator

from luxloop.scenarios.metrics.definition import MetricDefinition, Selection, with_filters
from luxloop.scenarios.metrics.definitions import ANY, find_metric
from luxloop.sim.world import Kind

PREFIX = "own."
"""Beginning of the names of own metrics in results, which no shipped metric has."""
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
    def selection(self) -> Selection:
        """The shipped metric over the chosen actors."""
        filters = {"class": "|".join(self.classes), "actor": "|".join(self.actors)}
        return with_filters(find_metric(self.of), {key: value for key, value in filters.items() if value})

    @property
    def definition(self) -> MetricDefinition:
        """Name, unit and meaning."""
        if self.function:
            meaning = self.meaning or f"value of {self.function}"
            return MetricDefinition(self.name, self.unit or "1", meaning, "own", better="", range=ANY)
        chosen = self.selection
        return replace(chosen.definition, name=self.name, meaning=self.meaning or chosen.meaning)

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
        if not (self.actors or self.classes):
            raise ValueError(f"give actor or class, or use {self.of} itself")
        try:
            definition = find_metric(self.of).definition
        except ValueError as error:
            raise ValueError(f'of = "{self.of}": {error}') from error
        for key in [*["actor"] * bool(self.actors), *["class"] * bool(self.classes)]:
            if key not in definition.filters:
                raise ValueError(f'of = "{self.of}": no metric of single actors; it cannot be restricted to a {key}')
        if unknown := [name for name in self.classes if name not in KINDS]:
            raise ValueError(f'class = "{unknown[0]}": no class of actors; name one of {", ".join(KINDS)}')
        if self.unit:
            raise ValueError(f'unit = "{self.unit}": leave it out, the unit is that of {self.of}')


def definitions_of(metrics: Iterable[OwnMetric]) -> dict[str, MetricDefinition]:
    """Return the definitions by name.

    Raises
    ------
    ValueError
        A name is defined twice.
    """
    found: dict[str, MetricDefinition] = {}
    for metric in metrics:
        if metric.name in found:
            raise ValueError(f"{metric.name} is defined twice; give each metric a name of its own")
        found[metric.name] = metric.definition
    return found
