"""Model and loading of scenario files.

Each stage has its own dataclass of settings. pydantic validates a file against them and forbids unknown keys.
"""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache, reduce
from operator import or_
from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal, Self

from pydantic import (
    AfterValidator,
    BaseModel,
    ConfigDict,
    Field,
    GetCoreSchemaHandler,
    PrivateAttr,
    ValidationError,
    ValidationInfo,
    field_validator,
)
from pydantic.json_schema import model_json_schema
from pydantic_core import CoreSchema

from luxloop.plugins import PluginError
from luxloop.scenarios.control.control_config import CruiseConfig
from luxloop.scenarios.errors import ScenarioError
from luxloop.scenarios.files import input_file
from luxloop.scenarios.files.expect import Limit, check_unit, metric_name
from luxloop.scenarios.files.settings import applied as set_keys
from luxloop.scenarios.files.validation_message import explain, implausible
from luxloop.scenarios.grading.grading_config import GradingConfig
from luxloop.scenarios.metrics.own_metric import OwnMetric, definitions_of
from luxloop.sensor_model.noise.noise_config import NoiseConfig
from luxloop.sensor_model.sensor_config import SensorConfig
from luxloop.sim.factory import KINDS, TrafficConfig
from luxloop.tracker.tracker import TrackerConfig

DEFAULT_SEED = 1
_LARGEST_SEED = 2**31 - 1  # SUMO's seed is a signed 32-bit number
_LONGEST_S = 86_400.0  # a day: at its end, grading loads the tables of a run


@dataclass(frozen=True, slots=True)
class RigChoice:
    """The rig on the ego: a shipped rig by `name`, or another by `file`."""

    name: str | None = None
    """A file of `sensor_model/rigs`, without `.toml`."""
    file: str | None = None
    """Path of a rig file, relative to the scenario file."""

    def __post_init__(self) -> None:
        if (self.name is None) == (self.file is None):
            raise ValueError("give either name (a shipped rig) or file (the path of a rig file)")

    def __str__(self) -> str:
        return self.name or self.file or ""


class TrafficTable:
    """Schema of `[traffic]`: one of the kinds that are in use, discriminated by `kind`.

    A kind of a plug-in comes into use when a file first names it, so that no other plug-in is imported.
    """

    in_use: ClassVar[dict[str, Any]] = dict(KINDS.core)
    checked: ClassVar[set[str]] = set()

    @classmethod
    def use(cls, document: Mapping[str, Any]) -> None:
        """Take the kind of a file into use; of a file without a known one, all kinds, for the message.

        Raises
        ------
        PluginError
            The kind is registered twice, or its plug-in cannot be used.
        """
        table = document.get("traffic")
        kind = str(table.get("kind")) if isinstance(table, dict) else ""
        if kind not in cls.checked:
            cls._add({kind: KINDS.load(kind)} if kind in KINDS.names() else KINDS.load_all())
            cls.checked.add(kind)

    @classmethod
    def use_shipped(cls) -> None:
        """Take all kinds that ship with luxloop into use, and no others."""
        cls.in_use = {kind: KINDS.load(kind) for kind in KINDS.names(of_luxloop=True)}
        cls.checked.clear()

    @classmethod
    def _add(cls, kinds: Mapping[str, Any]) -> None:
        if not kinds.keys() <= cls.in_use.keys():
            cls.in_use |= kinds
            _build(Scenario, described=False)
            _schema.cache_clear()

    @classmethod
    def __get_pydantic_core_schema__(cls, _source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        """Return the schema of the union."""
        union: Any = reduce(or_, cls.in_use.values())
        return handler.generate_schema(Annotated[union, Field(discriminator="kind")])


class Scenario(BaseModel):
    """A scenario file."""

    model_config = ConfigDict(
        extra="forbid", frozen=True, strict=True, allow_inf_nan=False, use_attribute_docstrings=True, defer_build=True
    )

    description: Annotated[str, Field(min_length=1)]
    """Description of the traffic situation and its purpose, in one English sentence."""
    reason: str = ""
    """Motivation: where the situation occurs, and which errors only this scenario reveals."""
    suite: Literal["smoke", "full"] = "full"
    """`smoke` for the small set that runs on every change; the full suite contains all scenarios."""
    seed: Annotated[int, Field(ge=0, le=_LARGEST_SEED)] = DEFAULT_SEED
    """Seed of traffic and noise."""
    duration_s: Annotated[float, Field(gt=0, le=_LONGEST_S)]
    """Simulated time [s]."""
    traffic: Annotated[TrafficConfig, TrafficTable]
    """Traffic simulator, and the traffic it simulates."""
    rig: RigChoice = RigChoice(name="srx_six_lux")
    """LIDARs mounted on the ego."""
    sensor: SensorConfig = SensorConfig()
    """Fidelity of the LIDAR simulation."""
    noise: NoiseConfig = NoiseConfig()
    """Measurement errors of the points."""
    tracker: TrackerConfig = TrackerConfig()
    """Settings of the tracker that differ from its defaults."""
    control: CruiseConfig | None = None
    """Speed controller of the ego, requires `traffic.ego_control = true`; if left out, the simulator drives the ego."""
    grading: GradingConfig = GradingConfig()
    """Conditions under which vehicles and tracks are graded."""
    metric: list[OwnMetric] = []
    """Metrics of one's own, beside the shipped ones."""
    expect: dict[Annotated[str, AfterValidator(metric_name)], Limit] = {}
    """Limits by metric; a run that violates one fails."""

    _path: Path = PrivateAttr()
    _document: dict[str, Any] = PrivateAttr()
    _settings: tuple[str, ...] = PrivateAttr(default=())
    _written: dict[str, Any] | None = PrivateAttr(default=None)
    """Content of the file at `_path`, None for a scenario that was not read from one."""

    @field_validator("control")
    @classmethod
    def _require_ego_control(cls, control: CruiseConfig | None, others: ValidationInfo) -> CruiseConfig | None:
        traffic = others.data.get("traffic")  # absent if it is itself invalid
        if control and traffic and not getattr(traffic, "ego_control", False):
            raise ValueError('the ego cannot be controlled; set traffic.kind = "sumo" and ego_control = true')
        return control

    @field_validator("metric")
    @classmethod
    def _require_distinct_names(cls, metric: list[OwnMetric]) -> list[OwnMetric]:
        definitions_of(metric)
        return metric

    @field_validator("expect")
    @classmethod
    def _require_metric_units(cls, expect: dict[str, Limit], others: ValidationInfo) -> dict[str, Limit]:
        if "metric" in others.data:  # absent if it is itself invalid
            for name, limit in expect.items():
                check_unit(name, limit, others.data["metric"])
        return expect

    @classmethod
    def load(cls, path: Path, overrides: Mapping[str, Any] | None = None, settings: Sequence[str] = ()) -> Self:
        """Read a scenario file; `overrides` replace its top-level keys, `settings` any keys (KEY=VALUE).

        Raises
        ------
        ScenarioError
            The file is missing or not TOML, or a key is missing, unknown, or of a wrong type or value.
        """
        written, own = input_file.read_toml(path), {"seed": DEFAULT_SEED}
        changed = set_keys(written, settings) | dict(overrides or {})
        scenario = cls._validated(changed, path)
        scenario._settings, scenario._written = tuple(settings), written
        return scenario if own | changed == own | written else scenario._without_figures()

    @classmethod
    def of(cls, document: dict[str, Any], path: Path) -> Self:
        """Make a scenario from the content of its file, which need not exist.

        `path` sets its name, and the folder that its relative paths start from. Its known failures have no figures.

        Raises
        ------
        ScenarioError
            A key is missing, unknown, or of a wrong type or value.
        """
        return cls._validated(document, path)._without_figures()

    def with_keys(self, overrides: Mapping[str, Any], settings: Sequence[str] = ()) -> Self:
        """Return the scenario with other values of some keys; parameters and errors as `load`."""
        changed, own = set_keys(self._document, settings) | dict(overrides), {"seed": DEFAULT_SEED}
        same = own | changed == own | self._document
        scenario = self.model_copy() if same else self.of(changed, self._path)
        scenario._settings, scenario._written = (*self._settings, *settings), self._written
        return scenario

    def require_unchanged(self) -> None:
        """Check that the file still has the content that was read, with its limits.

        Raises
        ------
        ScenarioError
            It was changed or removed meanwhile.
        """
        if self._written is not None and input_file.read_toml(self._path) != self._written:
            raise ScenarioError(f"{self._path}: was changed after it was read; run it again")

    @classmethod
    def parse(cls, document: dict[str, Any]) -> Self:
        """Make a scenario from the content of its file, or from the settings of a run.

        Raises
        ------
        ValidationError
            A key is missing, unknown, or of a wrong type or value.
        PluginError
            The plug-in of its traffic cannot be used.
        """
        TrafficTable.use(document)
        # In strict mode, JSON may give lists for tuples and texts for paths, but not "12" for 12.
        return cls.model_validate_json(json.dumps(document, default=str))

    @classmethod
    def model_json_schema(cls, *arguments: Any, **named: Any) -> dict[str, Any]:
        """Return the JSON schema of luxloop's own keys, with their docstrings as descriptions."""
        if not cls.model_config["use_attribute_docstrings"]:
            TrafficTable.use_shipped()
            _build(cls, described=True)
        return super().model_json_schema(*arguments, **named)

    @classmethod
    def _validated(cls, document: dict[str, Any], path: Path) -> Self:
        if wrong := implausible(document):
            raise ScenarioError(f"{path}: {wrong}")
        try:
            scenario = cls.parse(document)
        except PluginError as error:
            raise ScenarioError(f"{path}: traffic.kind: {error}") from error
        except ValidationError as error:
            raise ScenarioError(f"{path}: {explain(error, document, _schema(cls))}") from error
        scenario._path, scenario._document = path, document
        return scenario

    def _without_figures(self) -> Self:
        """Return the scenario without the figures of known failures, which are those of the file as it is written."""
        return self.model_copy(update={"expect": {name: limit.without_figure() for name, limit in self.expect.items()}})

    @property
    def path(self) -> Path:
        """Path of the file."""
        return self._path

    @property
    def settings(self) -> tuple[str, ...]:
        """Keys set on the command line, as KEY=VALUE."""
        return self._settings

    @property
    def name(self) -> str:
        """File name without `.toml`."""
        return self._path.stem

    @property
    def folder(self) -> Path:
        """Folder that relative paths in the file start from."""
        return self._path.parent


def _build(model: type[BaseModel], *, described: bool) -> None:
    """Build the validator of a model, with or without descriptions of the keys of its dataclasses.

    For descriptions, pydantic parses the source of each dataclass, which takes most of the import of this module.
    """
    model.model_config["use_attribute_docstrings"] = described
    model.model_rebuild(force=True)


_build(Scenario, described=False)


@cache
def _schema(model: type[BaseModel]) -> dict[str, Any]:
    """Return the JSON schema for messages on wrong keys, which quote no descriptions."""
    return model_json_schema(model)


def schema_text(model: type[BaseModel] = Scenario) -> str:
    """Return the JSON schema of scenario files, or of another model, as committed in `scenarios/schema/`."""
    return json.dumps(model.model_json_schema(), indent=2, ensure_ascii=False) + "\n"
