"""Scenario files: what may stand in them, and how they are read.

Each stage's settings are that stage's own dataclass; pydantic holds a file against them, unknown keys forbidden.
"""

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Literal, Self

from pydantic import (
    AfterValidator,
    BaseModel,
    ConfigDict,
    Field,
    PrivateAttr,
    ValidationError,
    ValidationInfo,
    field_validator,
)

from scenarios.control.control_config import CruiseConfig
from scenarios.errors import ScenarioError
from scenarios.files import toml_file
from scenarios.files.expect import Limit, check_unit, metric_name
from scenarios.files.validation_message import explain, implausible
from scenarios.grading.grading_config import GradingConfig
from sensor_model.noise.noise_config import NoiseConfig
from sensor_model.sensor_config import SensorConfig
from sim.highway.highway_config import HighwayTraffic
from sim.replay.replay_config import ReplayTraffic
from sim.scripted.scripted_source import ScriptedTraffic
from sim.sumo.sumo_config import SumoTraffic
from tracker.tracker import TrackerConfig

DEFAULT_SEED = 1
_LARGEST_SEED = 2**31 - 1  # SUMO's seed is a signed 32-bit number
_LONGEST_S = 86_400.0  # a day: a run is kept in memory until it ends


@dataclass(frozen=True, slots=True)
class RigChoice:
    """Which rig the ego carries: a shipped one by `name`, or one's own by `file`."""

    name: str | None = None
    """A file of `sensor_model/rigs`, without `.toml`."""
    file: str | None = None
    """Path of a rig file, relative to the scenario file."""

    def __post_init__(self) -> None:
        if (self.name is None) == (self.file is None):
            raise ValueError("give either name (a shipped rig) or file (the path of a rig file)")

    def __str__(self) -> str:
        return self.name or self.file or ""


class Scenario(BaseModel):
    """One scenario file."""

    model_config = ConfigDict(
        extra="forbid", frozen=True, strict=True, allow_inf_nan=False, use_attribute_docstrings=True
    )

    description: Annotated[str, Field(min_length=1)]
    """One English sentence: what happens, and what it is for."""
    reason: str = ""
    """Why it is worth running: who meets this, and what would go unnoticed without it."""
    suite: Literal["smoke", "full"] = "full"
    """`smoke` for the few that run on every change; all are part of the full suite."""
    seed: Annotated[int, Field(ge=0, le=_LARGEST_SEED)] = DEFAULT_SEED
    """Seed of the traffic and of the noise."""
    duration_s: Annotated[float, Field(gt=0, le=_LONGEST_S)]
    """Simulated time [s]."""
    traffic: Annotated[SumoTraffic | HighwayTraffic | ScriptedTraffic | ReplayTraffic, Field(discriminator="kind")]
    """Who simulates the traffic, and what happens in it."""
    rig: RigChoice = RigChoice(name="srx_six_lux")
    """The LIDARs around the ego."""
    sensor: SensorConfig = SensorConfig()
    """How closely the LIDARs are simulated."""
    noise: NoiseConfig = NoiseConfig()
    """What is wrong with the points."""
    tracker: TrackerConfig = TrackerConfig()
    """Settings of the tracker that differ from its defaults."""
    control: CruiseConfig | None = None
    """Who drives the ego; left out, the traffic's own model does. It needs `traffic.ego_control = true`."""
    grading: GradingConfig = GradingConfig()
    """What counts, and when."""
    expect: dict[Annotated[str, AfterValidator(metric_name)], Limit] = {}
    """Limits by metric; a run that exceeds one has failed."""

    _path: Path = PrivateAttr()

    @field_validator("control")
    @classmethod
    def _require_an_ego_that_obeys(cls, control: CruiseConfig | None, others: ValidationInfo) -> CruiseConfig | None:
        traffic = others.data.get("traffic")  # absent if it is wrong itself
        if control and traffic and not getattr(traffic, "ego_control", False):
            raise ValueError('the ego obeys no speed here; use traffic.kind = "sumo" with ego_control = true')
        return control

    @field_validator("expect")
    @classmethod
    def _require_the_metrics_units(cls, expect: dict[str, Limit]) -> dict[str, Limit]:
        for name, limit in expect.items():
            check_unit(name, limit)
        return expect

    @classmethod
    def load(cls, path: Path, overrides: Mapping[str, Any] | None = None) -> Self:
        """Read a scenario file, its top-level keys replaced by `overrides`.

        Raises
        ------
        ScenarioError
            The file is missing, is not TOML, or has a key that is missing, unknown, or of a wrong type or value.
        """
        return cls.of(toml_file.read(path) | dict(overrides or {}), path)

    @classmethod
    def of(cls, document: dict[str, Any], path: Path) -> Self:
        """Make a scenario of what stands in its file, or would.

        `path` gives it its name, and its folder is where the paths in it start.

        Raises
        ------
        ScenarioError
            A key is missing, unknown, or of a wrong type or value.
        """
        if wrong := implausible(document):
            raise ScenarioError(f"{path}: {wrong}")
        try:
            # By way of JSON, whose strict mode takes lists for tuples and texts for paths, but no "12" for 12.
            scenario = cls.model_validate_json(json.dumps(document, default=str))
        except ValidationError as error:
            raise ScenarioError(f"{path}: {explain(error, document, cls.model_json_schema())}") from error
        scenario._path = path
        return scenario

    @property
    def path(self) -> Path:
        """The file."""
        return self._path

    @property
    def name(self) -> str:
        """The file's name without its ending."""
        return self._path.stem

    @property
    def folder(self) -> Path:
        """Where the paths in the file start."""
        return self._path.parent


def schema_text(model: type[BaseModel] = Scenario) -> str:
    """The JSON schema of scenario files, or of those of another model, as committed in `scenarios/schema/`."""
    return json.dumps(model.model_json_schema(), indent=2, ensure_ascii=False) + "\n"
