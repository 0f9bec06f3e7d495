"""Study files: a scenario, the parameters to vary, and the seeds."""

from pathlib import Path
from typing import Annotated, Any, Literal, Self

from pydantic import AfterValidator, Field, PrivateAttr, ValidationError, model_validator

from luxloop.scenarios.errors import ScenarioError, StudyError
from luxloop.scenarios.files import input_file, option_values, shipped
from luxloop.scenarios.files.expect import Limit, metric_name, unit_of
from luxloop.scenarios.files.validation_message import explain
from luxloop.scenarios.metrics.definition import MetricDefinition, Selection
from luxloop.scenarios.metrics.definitions import SURVIVAL, find_metric, is_metric, standard_names, survival_measure
from luxloop.scenarios.metrics.own_metric import PREFIX, OwnMetric, definitions_of
from luxloop.scenarios.study.parameter import Parameter, Strict, Value, distinct

Json = dict[str, Any]
Seed = Annotated[int, Field(ge=0)]


def find(name_or_path: str) -> Path:
    """Return the file of a shipped study by its name, or of any study by its path (ending in .toml).

    Raises
    ------
    StudyError
        No study of this name ships.
    """
    return shipped.find_in(shipped.studies(), name_or_path, "study", "luxloop list --studies", StudyError)


class Curve(Strict):
    """A figure of the report."""

    metric: Annotated[str, AfterValidator(metric_name)]
    """Metric on the vertical axis."""
    against: str | None = None
    """Horizontal axis: the key of a parameter, or a metric measured in each run. Required except for `survival`, whose
    axis is its metric."""
    by: str | None = None
    """Key of a parameter with one curve per value; for a `map`, the vertical axis."""
    panels: str | None = None
    """Key of a parameter with one panel of the figure per value."""
    kind: Literal["curve", "map", "survival"] = "curve"
    """Curves with 95 % confidence intervals; a heat map over two parameters; or, for a metric
    `emergence.<time_s, delay_s, meeting_m or meeting_s>{stage=...}`, the share of runs that have reached the stage
    (Kaplan-Meier), in which runs that never reach it count."""
    title: str = ""
    """Title of the figure; default: the metric's meaning."""

    @property
    def keys(self) -> list[str]:
        """Parameters (or metric) of the axes, curves and panels."""
        return [key for key in (self.panels, self.by, self.against) if key is not None]

    @property
    def axis(self) -> str:
        """Key of the horizontal axis; its metric for a survival curve."""
        return self.against or self.metric

    @model_validator(mode="after")
    def _keys_differ(self) -> Self:
        if len(set(self.keys)) < len(self.keys):
            raise ValueError("against, by and panels must name different parameters")
        if self.kind == "survival":
            self._check_survival()
        elif self.against is None:
            raise ValueError("a curve needs against, the key of its horizontal axis")
        if self.kind == "map" and self.by is None:
            raise ValueError("a map has two axes; name a second parameter with by")
        return self

    def _check_survival(self) -> None:
        if self.against is not None:
            raise ValueError(f"against = {self.against}: leave it out, the axis of a survival curve is its metric")
        if survival_measure(self.metric) is None:
            raise ValueError(
                f"metric = {self.metric}: has no survival curve; name one like emergence.meeting_m{{stage=confirmed}}, "
                f"of {', '.join(SURVIVAL)}"
            )


class Search(Strict):
    """Goal of `luxloop search`: the smallest disturbance with which a metric violates its limit."""

    metric: str
    """Metric that should fail."""
    min: float | None = None
    """The metric fails below this value."""
    max: float | None = None
    """The metric fails above this value."""
    need: str = ""
    """Reason or source of the limit; copied into the scenario file of the finding."""
    trials: Annotated[int, Field(ge=1)] = 150
    """Number of runs of the search; reducing the finding takes additional runs."""
    reduction_runs: Annotated[int, Field(ge=0)] = 150
    """Maximum number of runs that reduce the finding."""
    at_once: Annotated[int, Field(ge=1)] = 4
    """Runs proposed as one batch, independent of each other's results: the maximum number of parallel runs."""

    @model_validator(mode="after")
    def _a_limit_of_a_metric(self) -> Self:
        metric_name(self.metric)
        Limit(self.min, self.max)
        return self

    @property
    def limit(self) -> Limit:
        """The limit, as in a scenario's `[expect]`; without a unit for a metric of one's own, whose table has it."""
        return Limit(
            self.min, self.max, "" if self.metric.startswith(PREFIX) else find_metric(self.metric).unit, self.need
        )


class Threshold(Strict):
    """Goal of `luxloop thresholds`: the value of a parameter at which a share of runs keeps a metric, by setting."""

    key: str
    """Varied parameter, with a range, whose value is found; the combinations of the others are the settings."""
    metric: Annotated[str, AfterValidator(metric_name)]
    """Metric from 0 to 1 in every run, such as `track.occlusion_survival`."""
    shares: Annotated[list[Annotated[float, Field(gt=0.0, le=0.95)]], AfterValidator(distinct)] = Field(
        default_factory=lambda: [0.5, 0.95]
    )
    """Shares whose values are estimated; at most 0.95, because up to 4 % of runs may fail at any value."""
    runs: Annotated[int, Field(ge=2)] = 20
    """Number of runs of each setting."""
    rising: bool = False
    """True if the metric rises with the value, e.g. with the visible share; it falls with the time hidden."""


class Study(Strict):
    """A study file."""

    description: Annotated[str, Field(min_length=1)]
    """English sentence with the varied parameters and the question."""
    scenario: str
    """Name from `luxloop list`, path of a scenario file (relative to the study file's folder), or staged scene:
    `MODULE:FUNCTION`, a function that returns a scenario for its parameters."""
    seeds: Annotated[int, Field(ge=1)] | list[Seed] = 1
    """Number of seeds (1, 2, ...), or a list of seeds. Every combination of parameters runs with the same seeds."""
    samples: Annotated[int, Field(ge=1)] | None = None
    """Number of combinations drawn from the ranges (Latin hypercube); default: all combinations."""
    fixed: dict[str, Any] = Field(default_factory=dict)
    """Keys of the scenario file (or parameters of the scene) set to a constant value in the whole study."""
    vary: Annotated[list[Parameter], Field(min_length=1)]
    """Varied parameters."""
    metric: list[OwnMetric] = Field(default_factory=list)
    """Metrics of one's own, added to those of the scenario in every run; curves and the search may name them."""
    curve: list[Curve] = Field(default_factory=list)
    """Figures of the report."""
    search: Search | None = None
    """Goal of `luxloop search`."""
    threshold: Threshold | None = None
    """Goal of `luxloop thresholds`."""

    _path: Path = PrivateAttr()

    @model_validator(mode="after")
    def _parameters_are_consistent(self) -> Self:
        keys = [parameter.key for parameter in self.vary]
        if len(set(keys)) < len(keys):
            raise ValueError("a key is varied twice; put all its values into one [[vary]] table")
        targets = [key for parameter in self.vary for key in parameter.targets]
        if repeated := [key for key in dict.fromkeys(targets) if targets.count(key) > 1]:
            raise ValueError(f"{repeated[0]} is set twice by [[vary]] tables; take it out of one of them")
        if twice := sorted({*targets, *keys} & {*self.fixed}):
            raise ValueError(f"{twice[0]} is both varied and fixed; take it out of [fixed]")
        if "seed" in (*targets, *keys, *self.fixed):
            raise ValueError("seed cannot be varied or fixed; every combination runs with each of `seeds`")
        self._check_threshold()
        for parameter in self.vary:
            if self.search and parameter.neutral is None:
                raise ValueError(f"{parameter.key}: give neutral, the undisturbed value; the search needs it")
            adaptive = self.search or (self.threshold and self.threshold.key == parameter.key)
            if not (self.samples or adaptive or parameter.values or parameter.steps):
                raise ValueError(f"{parameter.key}: a range without steps; give steps, or samples for the whole study")
        if isinstance(self.seeds, list):
            distinct(self.seeds)
        for curve in self.curve:
            unit_of(curve.metric, self.metric)
            self._check_axes(curve, keys)
        for goal in (self.search, self.threshold):
            if goal:
                unit_of(goal.metric, self.metric)
        return self

    def scenario_values(self, values: dict[str, Value]) -> dict[str, Value]:
        """Return the keys that parameters set with their values; fixed keys are returned as they are."""
        tied = {parameter.key: parameter.sets for parameter in self.vary if parameter.sets}
        found: dict[str, Value] = {}
        for key, value in values.items():
            found |= {one.key: one.value(value) for one in tied[key]} if key in tied else {key: value}
        return found

    def _check_threshold(self) -> None:
        """Raise a ValueError if `[threshold]` does not name a varied range."""
        ranges = [parameter.key for parameter in self.vary if parameter.values is None]
        if self.threshold and self.threshold.key not in ranges:
            raise ValueError(
                f"threshold.key = {self.threshold.key}: not a [[vary]] table with low and high; "
                f"{'name one of ' + ', '.join(ranges) if ranges else 'give one a range'}"
            )

    def definition(self, name: str) -> Selection | MetricDefinition | None:
        """Return a shipped metric or one of this study by its name; None for other names."""
        return find_metric(name) if is_metric(name) else definitions_of(self.metric).get(name)

    @property
    def filtered_metrics(self) -> tuple[str, ...]:
        """Metrics of this study that results do not hold without being asked: those with filters."""
        named = [name for curve in self.curve for name in (curve.metric, *curve.keys)]
        named += [goal.metric for goal in (self.search, self.threshold) if goal]
        standard = set(standard_names())
        return tuple(dict.fromkeys(name for name in named if is_metric(name) and name not in standard))

    def _check_axes(self, curve: Curve, keys: list[str]) -> None:
        """Raise a ValueError if an axis is not a varied parameter, or (horizontal axis of curves only) a metric."""
        for key in curve.keys:
            measured = key == curve.against and curve.kind == "curve" and self.definition(key) is not None
            if key not in keys and not measured:
                raise ValueError(
                    f"curve over {key}: neither a varied parameter nor a metric; name one of {', '.join(keys)}"
                )

    @classmethod
    def load(cls, path: Path) -> Self:
        """Read a study file.

        Raises
        ------
        StudyError
            The file is missing, is not TOML, or has a key that is missing, unknown, or of a wrong type or value.
        """
        try:
            document = input_file.read_toml(path)
        except ScenarioError as error:
            raise StudyError(str(error)) from error
        try:
            study = cls.model_validate(document)
        except ValidationError as error:
            raise StudyError(f"{path}: {explain(error, document, cls.model_json_schema())}") from error
        study._path = path
        return study

    def with_seeds(self, text: str) -> Self:
        """Return the study with other seeds: "7", or "1-6" for all from the first to the last.

        Raises
        ------
        StudyError
            The text is not of this form.
        """
        changed = self.model_copy(update={"seeds": list(option_values.parse_seeds(text, StudyError))})
        changed._path = self._path
        return changed

    @property
    def path(self) -> Path:
        """Path of the file."""
        return self._path

    @property
    def seed_list(self) -> list[int]:
        """All seeds."""
        return self.seeds if isinstance(self.seeds, list) else list(range(1, self.seeds + 1))
