"""What is kept of a run to compare it with another: a few kilobytes, whether just read or from a baseline file."""

import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import pandas as pd

from scenarios.compare.sums import VehicleSums, vehicle_sums
from scenarios.errors import OutputError
from scenarios.files.expect import ExpectationOutcome, Limit, check
from scenarios.grading.grading_config import GradingConfig
from scenarios.result import Result
from scenarios.run import run_folder

PROSE = ("description", "reason", "suite")
"""Keys of a scenario that change nothing in its runs."""
LIMITS = "expect"
"""Key of the expectations, which are not compared but hold or not."""

TIMES = "perf."
"""Beginning of the names of metrics that are the machine's: they hold or not on that machine, and are not kept."""

TRACKERS = ("track_id", "segments", "largest_segment_share")
"""Columns of the truth table that tell what the tracker made of it."""


class Key(NamedTuple):
    """What two runs must have in common to be a pair."""

    scenario: str
    seed: int

    def __str__(self) -> str:
        return f"{self.scenario} seed {self.seed}"


@dataclass(frozen=True, slots=True)
class Expectation:
    """An expectation of a scenario beside what came out."""

    outcome: ExpectationOutcome
    value: float | None
    limit: str

    @property
    def holds(self) -> bool:
        """Whether the value keeps to the limit."""
        return self.outcome in ("passed", "unexpected pass")


@dataclass(frozen=True, slots=True, eq=False)
class RunDigest:
    """One run."""

    key: Key
    trace_hash: str
    truth_hash: str
    """Of all that the tracker had no part in: where it is equal, both trackers were given the same traffic and points
    (of a run on the same kind of machine)."""
    ended_early: str
    """As in `Result`."""
    device: str
    sections: dict[str, str]
    """Fingerprint of each top-level key of the effective configuration."""
    versions: dict[str, str]
    expectations: dict[str, Expectation]
    vehicles: VehicleSums


def read_run(folder: Path) -> RunDigest:
    """Read and sum up the run in a folder.

    Raises
    ------
    OutputError
        There is none in it, or it is damaged or of another version.
    """
    try:
        result = run_folder.read(folder)
        return digest(result)
    except KeyError as error:
        raise OutputError(f"{folder}: the run has no {error}; run the scenario again with this version") from error
    except (TypeError, ValueError) as error:
        raise OutputError(f"{folder}: not the run of this version ({error}); run the scenario again") from error


def digest(result: Result) -> RunDigest:
    """Sum up a run.

    Raises
    ------
    KeyError, TypeError, ValueError
        It is of another version.
    """
    limits = {name: Limit(**limit) for name, limit in result.config[LIMITS].items() if not name.startswith(TIMES)}
    checks = check(result.metrics, limits)
    return RunDigest(
        key=Key(result.scenario, result.seed),
        trace_hash=result.trace_hash,
        truth_hash=_truth_hash(result.tables["truth"]),
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


def _truth_hash(truth: pd.DataFrame) -> str:
    rows = pd.util.hash_pandas_object(truth.drop(columns=[*TRACKERS]), index=False)
    return hashlib.blake2b(rows.to_numpy().tobytes(), digest_size=8).hexdigest()


def differing(base: Mapping[str, str], head: Mapping[str, str]) -> list[str]:
    """Keys that are not the same in both, or not in both."""
    return sorted(key for key in base.keys() | head.keys() if base.get(key) != head.get(key))
