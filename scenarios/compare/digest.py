"""Digest of a run for comparisons: a few kilobytes, computed from a run folder or read from a baseline file."""

import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

from pydantic import StrictInt

from luxloop.scenarios.compare.vehicle_sums import VehicleSums, vehicle_sums
from luxloop.scenarios.errors import OutputError
from luxloop.scenarios.files.expect import ExpectationOutcome, Limit, check
from luxloop.scenarios.grading.grading_config import GradingConfig
from luxloop.scenarios.oracle.stage import ORACLE
from luxloop.scenarios.result import Result
from luxloop.scenarios.run import run_folder

PROSE = ("description", "reason", "suite", "set", "metric", "ego", "missing")
"""Keys of a run's configuration without influence on its compared metrics; those that `--set` sets have it."""
LIMITS = "expect"
"""Key of the expectations."""

TIMES = "perf."
"""Prefix of metrics that depend on the machine. Their expectations are not part of a digest."""


class Key(NamedTuple):
    """Scenario and seed, which two runs of a pair have in common."""

    scenario: str
    seed: int

    def __str__(self) -> str:
        return f"{self.scenario} seed {self.seed}"


@dataclass(frozen=True, slots=True)
class Expectation:
    """An expectation of a scenario and its outcome."""

    outcome: ExpectationOutcome
    value: float | None
    limit: str

    @property
    def holds(self) -> bool:
        """True if the value is within the limit."""
        return self.outcome in ("passed", "unexpected pass")


@dataclass(frozen=True, slots=True)
class RunFacts:
    """Values of a run that are no sums."""

    scenario: str
    seed: StrictInt
    trace_hash: str
    ended_early: str
    """As in `Result`."""
    device: str
    sections: dict[str, str]
    """Fingerprint of the value of each top-level key of the effective configuration."""
    versions: dict[str, str]
    expectations: dict[str, Expectation]

    @property
    def key(self) -> Key:
        """Scenario and seed."""
        return Key(self.scenario, self.seed)


@dataclass(frozen=True, slots=True, eq=False)
class RunDigest(RunFacts):
    """Digest of one run."""

    vehicles: VehicleSums


def read_run(folder: Path) -> RunDigest:
    """Read a run folder and return its digest.

    Raises
    ------
    OutputError
        The folder has no run, or the run is damaged or of another version.
    """
    try:
        result = run_folder.read(folder)
        return digest(result)
    except KeyError as error:
        raise OutputError(f"{folder}: the run has no {error}; run the scenario again with this version") from error
    except (TypeError, ValueError) as error:
        raise OutputError(f"{folder}: not a run of this version ({error}); run the scenario again") from error


def digest(result: Result) -> RunDigest:
    """Return the digest of a result.

    Raises
    ------
    KeyError, TypeError, ValueError
        The result is of another version.
    """
    if result.config.get("in_process"):
        raise OutputError(
            f"{result.out or result.scenario}: its tracker ran in the process of the truth (--in-process); run it "
            "again without, named as FILE.py:NAME or MODULE:NAME"
        )
    if result.config["device"].startswith(ORACLE):
        raise OutputError(
            f"{result.out or result.scenario}: {result.config['device']} got the ground truth; run a tracker"
        )
    limits = {name: Limit(**limit) for name, limit in result.config[LIMITS].items() if not name.startswith(TIMES)}
    checks = check(result.metrics, limits, result.config["device"])
    return RunDigest(
        scenario=result.scenario,
        seed=result.seed,
        trace_hash=result.trace_hash,
        ended_early=result.ended_early,
        device=result.config["device"],
        sections={key: _fingerprint(value) for key, value in result.config.items() if key not in PROSE},
        versions=result.versions,
        expectations={check.name: Expectation(check.outcome, check.metric.value, str(check.limit)) for check in checks},
        vehicles=vehicle_sums(result.tables, GradingConfig(**result.config["grading"])),
    )


def _fingerprint(section: Any) -> str:
    text = json.dumps(section, sort_keys=True)
    return hashlib.blake2b(text.encode(), digest_size=4).hexdigest()


def differing(base: Mapping[str, str], head: Mapping[str, str]) -> list[str]:
    """Return the keys with different values, or in one of the two only, sorted."""
    return sorted(key for key in base.keys() | head.keys() if base.get(key) != head.get(key))
