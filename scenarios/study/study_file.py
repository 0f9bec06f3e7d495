"""Study files: a scenario, what to vary in it, and with which seeds."""

from pathlib import Path
from typing import Annotated, Any, Literal, Self

from pydantic import AfterValidator, Field, PrivateAttr, ValidationError, model_validator

from scenarios.errors import ScenarioError, StudyError
from scenarios.files import shipped as listing
from scenarios.files import toml_file
from scenarios.files.expect import Limit, metric_name
from scenarios.files.validation_message import explain
from scenarios.grading.metric_names import METRICS
from scenarios.study.parameter import Strict, Vary, distinct

Json = dict[str, Any]
Seed = Annotated[int, Field(ge=0)]


def find(name_or_path: str) -> Path:
    """Return the file of a shipped study by its name, or of one given by its path (which ends in .toml).

    Raises
    ------
    StudyError
        There is none of that name.
    """
    if name_or_path.endswith(".toml"):
        return Path(name_or_path)
    shipped = listing.studies()
    if name_or_path not in shipped:
        raise StudyError(f"{name_or_path}: no such study; these ship: {', '.join(shipped)} (a path ends in .toml)")
    return shipped[name_or_path]


class Curve(Strict):
    """One picture of the report."""

    metric: Annotated[str, AfterValidator(metric_name)]
    """What is drawn, upwards."""
    against: str
    """The key of the parameter that is drawn to the right, or a metric that each run measured."""
    by: str | None = None
    """The key of a parameter that gives a curve to each of its values; with `map`, the one drawn upwards."""
    panels: str | None = None
    """The key of a parameter that gives a panel of the picture to each of its values."""
    kind: Literal["curve", "map"] = "curve"
    """Curves with their 95 % intervals, or a heat map over two parameters."""
    title: str = ""
    """What the picture shows; the metric's meaning if left out."""

    @property
    def keys(self) -> list[str]:
        """Columns that tell what is drawn where."""
        return [key for key in (self.panels, self.by, self.against) if key is not None]

    @model_validator(mode="after")
    def _keys_differ(self) -> Self:
        if len(set(self.keys)) < len(self.keys):
            raise ValueError("against, by and panels must name different parameters")
        if self.kind == "map" and self.by is None:
            raise ValueError("a map has two axes; name a second parameter with by")
        return self


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
    at_once: Annotated[int, Field(ge=1)] = 4
    """Runs that are proposed together, without knowing of each other: so many can run side by side."""

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
    """A name from `luxloop list`, the path of a scenario file (from the study file's folder on), or a staged scene:
    `MODULE:FUNCTION`, a function that makes a scenario of its parameters."""
    seeds: Annotated[int, Field(ge=1)] | list[Seed] = 1
    """How many, from 1 on, or a list of which. Every combination of parameters runs with the same seeds."""
    samples: Annotated[int, Field(ge=1)] | None = None
    """How many combinations are drawn from the ranges (Latin hypercube); if left out, all combinations run."""
    fixed: dict[str, Any] = Field(default_factory=dict)
    """Keys of the scenario file (or parameters of the scene) that have another value in the whole study."""
    vary: Annotated[list[Vary], Field(min_length=1)]
    """What is varied."""
    curve: list[Curve] = Field(default_factory=list)
    """What the report draws."""
    search: Search | None = None
    """What `luxloop search` looks for."""

    _path: Path = PrivateAttr()

    @model_validator(mode="after")
    def _ranges_can_be_enumerated(self) -> Self:
        keys = [vary.key for vary in self.vary]
        if len(set(keys)) < len(keys):
            raise ValueError("a key is varied twice; put all its values into one [[vary]]")
        if twice := sorted({*keys} & {*self.fixed}):
            raise ValueError(f"{twice[0]} is both varied and fixed; take it out of [fixed]")
        if "seed" in (*keys, *self.fixed):
            raise ValueError("seed is no parameter; every combination runs with each of `seeds`")
        for vary in self.vary:
            if self.search and vary.neutral is None:
                raise ValueError(f"{vary.key}: give neutral, its value where nothing is disturbed, for the search")
            if not (self.samples or self.search or vary.values or vary.steps):
                raise ValueError(f"{vary.key}: a range without steps; give steps, or samples for the whole study")
        if isinstance(self.seeds, list):
            distinct(self.seeds)
        for curve in self.curve:
            self._check_axes(curve, keys)
        return self

    @staticmethod
    def _check_axes(curve: Curve, keys: list[str]) -> None:
        """A picture is drawn over what is varied; a curve also over a metric that each run measured."""
        for key in curve.keys:
            measured = key == curve.against and curve.kind == "curve" and key in METRICS
            if key not in keys and not measured:
                raise ValueError(f"curve over {key}: it is neither varied nor a metric; name one of {', '.join(keys)}")

    @classmethod
    def load(cls, path: Path) -> Self:
        """Read a study file.

        Raises
        ------
        StudyError
            The file is missing, is not TOML, or has a key that is missing, unknown, or of a wrong type or value.
        """
        try:
            document = toml_file.read(path)
        except ScenarioError as error:
            raise StudyError(str(error)) from error
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
