"""Study files: a scenario, what to vary in it, and with which seeds."""

import tomllib
from pathlib import Path
from typing import Annotated, Any, Literal, Self

from pydantic import BaseModel, ConfigDict, Field, PrivateAttr, ValidationError, model_validator

from scenarios.errors import StudyError
from scenarios.expect import Limit, metric_name
from scenarios.explain import explain
from scenarios.grading.metrics import METRICS

Json = dict[str, Any]
Value = float | int | str | bool


class Strict(BaseModel):
    """Forbids what it does not know."""

    model_config = ConfigDict(
        extra="forbid", frozen=True, strict=True, allow_inf_nan=False, use_attribute_docstrings=True
    )


class Vary(Strict):
    """One parameter."""

    key: str
    """A key of the scenario file, as `noise.dropout.loss` or `traffic.actor[truck].x_m`; of a staged scene, the name of
    one of its parameters."""
    values: list[Value] | None = None
    """The values it takes; else a range."""
    low: float | None = None
    """Lower end of the range."""
    high: float | None = None
    """Upper end of the range."""
    steps: Annotated[int, Field(ge=2)] | None = None
    """Values on the range, both ends included; a study with `samples` draws from all of it instead."""
    scale: Literal["linear", "log"] = "linear"
    """How the range is divided, or drawn from."""
    label: str = ""
    """What the axis of a picture says, with the unit; the key if left out."""
    neutral: Value | None = None
    """Its value where nothing is disturbed; a search needs it."""

    @model_validator(mode="after")
    def _values_or_a_range(self) -> Self:
        if self.values is not None:
            if not self.values or (self.low, self.high, self.steps) != (None, None, None):
                raise ValueError("give values (at least one), or low and high of a range, not both")
        elif self.low is None or self.high is None or self.low >= self.high:
            raise ValueError("give values, or a range: low below high")
        elif self.scale == "log" and self.low <= 0:
            raise ValueError(f"low = {self.low:g}: a logarithmic range starts above 0")
        return self

    @model_validator(mode="after")
    def _neutral_is_among_them(self) -> Self:
        if self.neutral is None:
            return self
        if self.values is not None:
            if self.neutral not in self.values:
                raise ValueError(f"neutral = {self.neutral} is none of the values; add it to them")
            return self
        assert self.low is not None
        assert self.high is not None
        if isinstance(self.neutral, str) or not self.low <= self.neutral <= self.high:
            raise ValueError(f"neutral = {self.neutral} lies outside the range; widen it from low to high")
        return self


class Curve(Strict):
    """One picture of the report."""

    metric: str
    """What is drawn, upwards."""
    against: str
    """The key of the parameter that is drawn to the right, or a metric that each run measured."""
    by: str | None = None
    """The key of a parameter that gives a curve to each of its values; with `map`, the one drawn upwards."""
    kind: Literal["curve", "map"] = "curve"
    """A curve with its 95 % interval, or a heat map over two parameters."""


class Search(Strict):
    """What `luxloop search` looks for: the smallest disturbance with which a metric breaks its limit."""

    metric: str
    """The metric that is to fail."""
    min: float | None = None
    """It fails below this."""
    max: float | None = None
    """It fails above this."""
    need: str = ""
    """Who needs this limit, or where it comes from; goes into the scenario file that is found."""
    trials: Annotated[int, Field(ge=1)] = 150
    """Runs until the search ends; shrinking what was found takes some more."""

    @model_validator(mode="after")
    def _a_limit_of_a_metric(self) -> Self:
        metric_name(self.metric)
        Limit(self.min, self.max)
        return self

    @property
    def limit(self) -> Limit:
        """The limit, as in a scenario's `[expect]`."""
        return Limit(self.min, self.max, METRICS[self.metric], self.need)


class Study(Strict):
    """One study file."""

    description: Annotated[str, Field(min_length=1)]
    """One English sentence: what is varied, and what one wants to know."""
    scenario: str
    """A name from `luxloop list`, the path of a scenario file, or a staged scene, as
    `scenarios.study.staged:hidden_behind_truck`: a function that makes a scenario of its parameters."""
    seeds: Annotated[int, Field(ge=1)] | list[Annotated[int, Field(ge=0)]] = 1
    """How many, from 1 on, or which. Every combination of parameters runs with the same seeds."""
    samples: Annotated[int, Field(ge=1)] | None = None
    """How many combinations are drawn from the ranges (Latin hypercube); if left out, all combinations run."""
    fixed: dict[str, Any] = {}
    """Keys of the scenario file (or parameters of the scene) that have another value in the whole study."""
    vary: Annotated[list[Vary], Field(min_length=1)]
    """What is varied."""
    curve: list[Curve] = []
    """What the report draws."""
    search: Search | None = None
    """What `luxloop search` looks for."""

    _path: Path = PrivateAttr()

    @model_validator(mode="after")
    def _ranges_can_be_enumerated(self) -> Self:
        keys = [vary.key for vary in self.vary]
        if len(set(keys)) < len(keys):
            raise ValueError("a key is varied twice; put all its values into one [[vary]]")
        for vary in self.vary:
            if self.search and vary.neutral is None:
                raise ValueError(f"{vary.key}: give neutral, its value where nothing is disturbed, for the search")
            if not (self.samples or self.search or vary.values or vary.steps):
                raise ValueError(f"{vary.key}: a range without steps; give steps, or samples for the whole study")
        for curve in self.curve:
            metric_name(curve.metric)
            for key in filter(None, (curve.against, curve.by)):
                if key not in keys and not (key == curve.against and curve.kind == "curve"):
                    raise ValueError(f"curve over {key}: it is not varied; name one of {', '.join(keys)}")
                if key not in keys:
                    metric_name(key)
        return self

    @classmethod
    def load(cls, path: Path) -> Self:
        """Read a study file.

        Raises
        ------
        StudyError
            The file is missing, is not TOML, or has a key that is missing, unknown, or of a wrong type or value.
        """
        try:
            document = tomllib.loads(path.read_text(encoding="utf-8"))
        except OSError as error:
            raise StudyError(f"{path}: {error.strerror}; give a readable study file") from error
        except (UnicodeDecodeError, tomllib.TOMLDecodeError) as error:
            raise StudyError(f"{path}: not TOML: {error}; correct it") from error
        try:
            study = cls.model_validate(document)
        except ValidationError as error:
            raise StudyError(f"{path}: {explain(error, document, cls.model_json_schema())}") from error
        study._path = path
        return study

    @property
    def path(self) -> Path:
        """The file."""
        return self._path

    @property
    def seed_list(self) -> list[int]:
        """Every seed."""
        return self.seeds if isinstance(self.seeds, list) else list(range(1, self.seeds + 1))
