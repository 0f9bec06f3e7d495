"""Scans that a tracker is checked with: a simulated drive, and invalid or unusual scans."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from luxloop.arrays import Floats
from luxloop.scenarios.files import shipped
from luxloop.scenarios.files.scenario import Scenario
from luxloop.scenarios.run import loop
from luxloop.tracker.records import MODELS, Tracks
from luxloop.tracker.scan import Scan
from luxloop.tracker.tracker import TrackerConfig

SCENARIO, DURATION_S = "truck-shadow", 3.2
"""Simulated scenario: moving cars, a truck, and the beginning of an occlusion."""
DT_S = 0.08
GAP_S = 10.0
"""[s] Length of a gap without scans: all tracks end in it."""
MANY = 20_000
"""Number of points of one cluster; an algorithm quadratic in the points would take minutes."""


class CheckDrive(NamedTuple):
    """Scans for one instance of a tracker."""

    name: str
    scans: tuple[Scan, ...]
    labels: tuple[str, ...]
    """Kind of each unusual scan; empty for ordinary scans."""

    def where(self, index: int) -> str:
        """Return a description of one scan: drive, index, time and label."""
        label = f", {self.labels[index]}" if self.labels[index] else ""
        return f"{self.name}, scan {index} at {self.scans[index].time:.2f} s{label}"


def drives() -> list[CheckDrive]:
    """Return all drives: the simulated drive first, then variants and unusual scans."""
    simulated = simulated_scans()
    half = len(simulated) // 2
    late = [replace(scan, time=scan.time + GAP_S) for scan in simulated[half:]]
    epoch = [replace(scan, time=scan.time + 1.7e9) for scan in simulated[:half]]
    no_returns = [*simulated[:half], *map(_without_points, simulated[half : half + 5]), *simulated[half + 5 :]]
    return [
        _drive("simulated drive", simulated),
        _drive("simulated drive with a gap of 10 s", [*simulated[:half], *late]),
        _drive("simulated drive with 0.4 s without returns", no_returns),
        _drive("simulated drive with Unix time", epoch),
        _unusual_scans(),
    ]


def simulated_scans() -> list[Scan]:
    """Return the scans of a shipped scenario."""
    scans: list[Scan] = []
    scenario = Scenario.load(shipped.find(SCENARIO), {"duration_s": DURATION_S})
    loop.run(scenario, NullTracker, export=lambda _frame, scan, _truth, _grade: scans.append(scan))
    return scans


class NullTracker:
    """Device that reports no tracks, used to collect scans from the run loop."""

    def __init__(self, config: TrackerConfig) -> None:
        del config

    def step(self, scan: Scan) -> Tracks:
        """Return no tracks."""
        del scan
        return Tracks(
            id=np.empty(0, np.int64),
            status=np.empty(0, np.uint8),
            mean=np.empty((0, 8)),
            covariance=np.empty((0, 8, 8)),
            model_probability=np.empty((0, len(MODELS))),
            model=np.empty(0, np.int64),
            model_position_odom=np.empty((0, len(MODELS), 2)),
            corner_sign=np.empty((0, 2), np.int64),
            size=np.empty((0, 2)),
        )


def _drive(name: str, scans: list[Scan]) -> CheckDrive:
    return CheckDrive(name, tuple(scans), ("",) * len(scans))


def _without_points(scan: Scan) -> Scan:
    return Scan.from_points(scan.time, np.empty((0, 3)), scan.ego_pose_odom)


def _unusual_scans() -> CheckDrive:
    """Return each kind of unusual scan four times in succession, so that tracks can be confirmed on it."""
    side = np.column_stack([np.linspace(5.0, 9.4, 40), np.full(40, 3.0), np.full(40, 0.6)])
    rear = np.column_stack([np.full(20, 5.0), np.linspace(3.0, 4.8, 20), np.full(20, 0.6)])
    empty = np.empty((0, 3))

    def line(start: float, stop: float) -> Floats:
        return np.column_stack([np.linspace(start, stop, 15), np.full(15, 3.0), np.full(15, 0.6)])

    rng = np.random.default_rng(0)
    kinds = {
        "no points": empty,
        "one point": side[:1],
        "fifty identical points": np.repeat(side[:1], 50, axis=0),
        "points on a line": side,
        "a car's corner": np.vstack([side, rear]),
        "no points after a car": empty,
        "a short line of points": line(8.0, 9.5),
        "the same line with a gap": np.vstack([line(8.0, 8.2), line(9.3, 9.5)]),
        "non-finite points": np.array([[np.nan, 1.0, 1.0], [np.inf, -np.inf, 1.0], [6.0, 3.0, np.nan]]),
        "non-finite points beside a car": np.vstack([side, rear, np.full((5, 3), np.nan)]),
        "points on the ground only": side * [1.0, 1.0, 0.0],
        "points at maximum range": side * [30.0, 1.0, 1.0],
        f"{MANY} points in one cluster": np.vstack([side, rear])[rng.integers(0, 60, MANY)]
        + rng.normal(0.0, 0.03, (MANY, 3)),
    }
    labels = [label for label in kinds for _ in range(4)]
    scans = [Scan.from_points(DT_S * k, kinds[label], (0.1 * k, 0.0, 0.002 * k)) for k, label in enumerate(labels)]
    return CheckDrive("unusual scans", tuple(scans), tuple(labels))
