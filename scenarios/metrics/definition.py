"""Definition of a metric, and its name with parameters and filters: `track.missed_share{class=truck,range=0-30}`.

A metric is a figure over observations of one kind: a mean of a column, or a part over a whole. Parameters choose
columns (`fit.heading_abs_mean_deg{method=tlinkage}`), filters choose rows. This module imports quickly, because
scenario files are validated with it.
"""

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Literal

from luxloop.sensor_model.truth import View
from luxloop.sim.world import Kind

Better = Literal["more", "less", ""]
"""Direction of improvement; empty for descriptions of the data and for errors with a sign."""
Statistic = Literal["mean", "std", "rate", "median", "order_median", "p90", "order_p90", "given"]
"""Reduction of the values of the rows to a figure.

`mean` is the sum of `value` over that of `weight`, `std` the deviation divided by n. `rate` is a mean whose
observations are those of `weight`. `median` and `p90` interpolate; `order_median` and `order_p90` are order
statistics, so that censored values, which are infinite, count. `given` figures are computed together for a whole kind,
as HOTA and its parts.
"""

BANDS = ("range", "points", "time")
"""Filters by an interval of a quantity [m, count, s], the upper end excluded: `range=0-30`, `points=100-`."""
FILTERS = ("class", "view", "actor", *BANDS)
"""All filters. `class`, `view` and `actor` take alternatives: `class=truck|bus`."""
OF_VEHICLES = ("class", "view", "actor", "range", "time")
"""Filters of observations of vehicles."""


NAMES = {
    "class": tuple(kind.name.lower() for kind in Kind),
    "view": tuple(view.name.lower() for view in View),
}
"""Names that these filters accept."""


@dataclass(frozen=True, slots=True)
class Relevance:
    """Sizes of differences of a metric: the smallest relevant one, and the loss that a comparison must exclude."""

    absolute: float
    """Smallest relevant difference, in the metric's unit."""
    relative: float = 0.0
    """Smallest relevant difference, as a share of BASE's value; the larger of both applies."""
    full: float | None = None
    """Value of which the stated loss is a share; None: BASE's value."""

    def margin(self, base: float) -> float:
        """Return the smallest relevant difference from the value `base`."""
        return max(self.absolute, self.relative * abs(base))

    def stated_loss(self, base: float, share: float) -> float:
        """Return the loss of `share` from the value `base`, at least the smallest relevant difference."""
        return max(self.margin(base), share * (abs(base) if self.full is None else self.full))


@dataclass(frozen=True, slots=True)
class MetricDefinition:
    """A metric. Names of columns may contain parameters in braces."""

    name: str
    unit: str
    meaning: str
    """A line."""
    kind: str
    """Kind of the observations."""
    value: str = ""
    """Column of the values; rows with NaN do not count."""
    rows: str = ""
    """Column (bool) of the rows that count; empty: all."""
    weight: str = ""
    """Column of the denominators; empty: the number of rows."""
    statistic: Statistic = "mean"
    better: Better = "less"
    range: tuple[float, float] = (0.0, math.inf)
    """Possible range, which intervals do not leave."""
    parameters: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    """Possible values of each parameter. The first one is the default, unless it is `ANY`."""
    filters: tuple[str, ...] = ()
    """Filters that the metric can have."""
    interval: bool = True
    """True if the figure has a 95 % interval over vehicles."""
    why_none: str = ""
    """Reason without a row that counts; empty: that of the kind."""
    why_unknown: str = ""
    """Reason if rows count and no value is known; empty: `why_none`."""
    ranked_by: str = ""
    """Column of the size of an error, which ranks the observations that count against a share; empty: `value`."""
    needs: str = ""
    """Column of the table `tracks` without which results do not list the metric: boxes of files may have it."""
    compared: Relevance | None = None
    """Sizes of differences, if comparisons test this mean or rate beside the main metrics of each stage."""


REQUIRED = ""
"""First value of a parameter that has no default."""


@dataclass(frozen=True, slots=True)
class Selection:
    """A metric with its parameters and filters, as named by a text."""

    definition: MetricDefinition
    parameters: Mapping[str, str] = field(default_factory=dict)
    """Value of every parameter."""
    filters: Mapping[str, str] = field(default_factory=dict)

    @property
    def name(self) -> str:
        """The name in its shortest form: without defaults, parameters before filters."""
        inside = ",".join(f"{key}={value}" for key, value in self._given.items())
        return f"{self.definition.name}{{{inside}}}" if inside else self.definition.name

    @property
    def chosen(self) -> str:
        """Parameters and filters in words: `class truck, range 0-30`; empty without any but defaults."""
        return ", ".join(f"{key} {value}" for key, value in self._given.items())

    @property
    def _given(self) -> dict[str, str]:
        """Parameters that are not the default, and filters."""
        given = {key: value for key, value in self.parameters.items() if value != self.definition.parameters[key][0]}
        return given | dict(self.filters)

    @property
    def unit(self) -> str:
        """Unit of the value."""
        return self.definition.unit

    @property
    def meaning(self) -> str:
        """Meaning in one line, with parameters and filters."""
        return f"{self.definition.meaning}; {self.chosen}" if self.chosen else self.definition.meaning

    def column(self, name: str) -> str:
        """Return the name of a column with the parameters filled in."""
        return name.format(**self.parameters) if "{" in name else name


def filtered(name: str, **filters: str) -> str:
    """Return the name of a metric with further parameters or filters: `filtered("track.hota", class_="truck")`."""
    base, _, inside = name.removesuffix("}").partition("{")
    parts = [inside] * bool(inside) + [f"{key.rstrip('_')}={value}" for key, value in filters.items() if value]
    return f"{base}{{{','.join(parts)}}}" if parts else base


def band(value: str) -> tuple[float, float]:
    """Return the ends of a band such as `0-30` or `100-`.

    Raises
    ------
    ValueError
        The text is no band.
    """
    found = re.fullmatch(r"(\d+(?:\.\d+)?)-(\d+(?:\.\d+)?)?", value)
    if not found:
        raise ValueError(f'"{value}" is no band; write it as 0-30, or 30- without an upper end')
    low, high = float(found[1]), float(found[2]) if found[2] else math.inf
    if low >= high:
        raise ValueError(f'"{value}": the upper end is not above the lower one')
    return low, high


def select(definition: MetricDefinition, inside: str) -> Selection:
    """Return the selection of a metric by the text between the braces of its name.

    Raises
    ------
    ValueError
        A key or value is unknown, given twice, or missing.
    """
    parameters = {key: values[0] for key, values in definition.parameters.items()}
    filters: dict[str, str] = {}
    given: set[str] = set()
    for part in filter(None, inside.split(",")):
        key, equals, value = (text.strip() for text in part.partition("="))
        if not equals or not value:
            raise ValueError(f'"{part}": write KEY=VALUE')
        if key in given:
            raise ValueError(f"{key} is given twice")
        given.add(key)
        if key in parameters:
            _check_choice(key, value, definition.parameters[key])
            parameters[key] = value
        elif key in definition.filters:
            filters[key] = value
            _check_filter(key, value)
        else:
            known = ", ".join([*definition.parameters, *definition.filters])
            raise ValueError(
                f"{definition.name} has no {key}; " + (f"it has {known}" if known else "it has no filters")
            )
    if missing := [key for key, value in parameters.items() if value == REQUIRED]:
        choices = ", ".join(definition.parameters[missing[0]][1:])
        raise ValueError(f"{definition.name} needs {missing[0]}=, one of {choices}")
    order = [key for key in FILTERS if key in filters]
    return Selection(definition, parameters, {key: filters[key] for key in order})


def _check_filter(key: str, value: str) -> None:
    if key in BANDS:
        band(value)
    for one in value.split("|") if key in NAMES else ():
        _check_choice(key, one, NAMES[key])


def _check_choice(key: str, value: str, choices: tuple[str, ...]) -> None:
    if value not in choices or not value:
        raise ValueError(f'{key}="{value}": name one of {", ".join(filter(None, choices))}')


def with_filters(selection: Selection, filters: Mapping[str, str]) -> Selection:
    """Return the selection with further filters."""
    return replace(selection, filters={**selection.filters, **filters})
