"""Drives of a league: combinations of scenarios and seeds."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from luxloop.scenarios.errors import InputError
from luxloop.scenarios.files import shipped
from luxloop.scenarios.files.scenario import Scenario
from luxloop.scenarios.league.entrants import chosen


@dataclass(frozen=True, slots=True)
class Drive:
    """Scenario and seed that all trackers get."""

    scenario: str
    """Path of its file."""
    seed: int
    duration_max_s: float
    trackers: tuple[str, ...]
    """Names, and places of the user's own."""
    out: Path

    @property
    def stem(self) -> str:
        """Name of the scenario."""
        return Path(self.scenario).stem

    @property
    def name(self) -> str:
        """Name of its folders."""
        return f"{self.stem}-seed{self.seed}"

    def load(self) -> Scenario:
        """Return the scenario, shortened to the largest duration.

        Raises
        ------
        InputError
            The ego drives by the tracks, so that the scans depend on the tracker.
        """
        path = Path(self.scenario)
        scenario = Scenario.load(path, {"seed": self.seed})
        if scenario.control:
            raise InputError(f"{path}: control: the ego drives by its tracks, so trackers would have different scans")
        return Scenario.load(path, {"seed": self.seed, "duration_s": min(self.duration_max_s, scenario.duration_s)})


def drives(
    scenarios: Sequence[str], seeds: Sequence[int], duration_max_s: float, trackers: Sequence[str], out: Path
) -> list[Drive]:
    """Return all combinations of scenarios and seeds.

    Raises
    ------
    InputError, ScenarioError
        A scenario or tracker does not exist, two scenarios have the same name, or one cannot be in a league.
    """
    specs = tuple(entrant.spec for entrant in chosen(trackers))
    files = [str(shipped.find(name)) for name in scenarios]
    stems = [Path(file).stem for file in files]
    for stem in stems:
        if stems.count(stem) > 1:
            raise InputError(f"{stem}: given twice; scenarios of a league need different names")
    found = [Drive(file, seed, duration_max_s, specs, out) for seed in seeds for file in files]
    for drive in found:
        drive.load()
    return found
