"""The scans that a tracker is checked with: a simulated drive, and what no healthy rig delivers."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from scenarios.arrays import Floats
from scenarios.files import shipped
from scenarios.files.scenario import Scenario
from scenarios.run import loop
from tracker.records import MODELS, Tracks
from tracker.scan import Scan
from tracker.tracker import TrackerConfig

SCENARIO, DURATION_S = "truck-shadow", 3.2
"""What is simulated: moving cars, walls of a truck, an occlusion that begins."""
DT_S = 0.08
AFTER_S = 10.0
"""Length of a gap: whatever was followed before it is gone."""
MANY = 20_000
"""Points of one cluster; a method that looks at all pairs of them would take minutes."""


class CheckDrive(NamedTuple):
    """Scans for one instance of a tracker."""

    name: str
    scans: tuple[Scan, ...]
    labels: tuple[str, ...]
    """What is odd about each, empty for most."""

    def where(self, index: int) -> str:
        """Name one scan."""
        label = f", {self.labels[index]}" if self.labels[index] else ""
        return f"{self.name}, scan {index} at {self.scans[index].time:.2f} s{label}"


def drives() -> list[CheckDrive]:
    """Return the real drive first, and the odd ones after it."""
    real = simulated()
    half = len(real) // 2
    late = [replace(scan, time=scan.time + AFTER_S) for scan in real[half:]]
    epoch = [replace(scan, time=scan.time + 1.7e9) for scan in real[:half]]
    silence = [*real[:half], *map(_silent, real[half : half + 5]), *real[half + 5 :]]
    return [
        _drive("real drive", real),
        _drive("real drive with a gap of 10 s", [*real[:half], *late]),
        _drive("real drive with half a second of no returns", silence),
        _drive("clock of seconds since 1970", epoch),
        _odd_scans(),
    ]


def simulated() -> list[Scan]:
    """Scans of a shipped scenario."""
    scans: list[Scan] = []
    scenario = Scenario.load(shipped.find(SCENARIO), {"duration_s": DURATION_S})
    loop.run(scenario, Silent, export=lambda _frame, scan, _truth, _grade: scans.append(scan))
    return scans


class Silent:
    """A device that tracks nothing, and lets the run loop deliver scans."""

    def __init__(self, config: TrackerConfig) -> None:
        del config

    def step(self, scan: Scan) -> Tracks:
        """No tracks."""
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


def _silent(scan: Scan) -> Scan:
    return Scan.from_points(scan.time, np.empty((0, 3)), scan.ego_pose_odom)


def _odd_scans() -> CheckDrive:
    """Each kind of odd scan a few times, so that tracks may start of it, with nothing in between."""
    side = np.column_stack([np.linspace(5.0, 9.4, 40), np.full(40, 3.0), np.full(40, 0.6)])
    rear = np.column_stack([np.full(20, 5.0), np.linspace(3.0, 4.8, 20), np.full(20, 0.6)])
    nothing = np.empty((0, 3))

    def post(start: float, stop: float) -> Floats:
        return np.column_stack([np.linspace(start, stop, 15), np.full(15, 3.0), np.full(15, 0.6)])

    rng = np.random.default_rng(0)
    kinds = {
        "no points": nothing,
        "one point": side[:1],
        "fifty points in one place": np.repeat(side[:1], 50, axis=0),
        "points in one row": side,
        "a car's corner": np.vstack([side, rear]),
        "no points after a car": nothing,
        "a short row of points": post(8.0, 9.5),
        "the same row with a gap in it": np.vstack([post(8.0, 8.2), post(9.3, 9.5)]),
        "points that are not finite": np.array([[np.nan, 1.0, 1.0], [np.inf, -np.inf, 1.0], [6.0, 3.0, np.nan]]),
        "points that are not finite beside a car": np.vstack([side, rear, np.full((5, 3), np.nan)]),
        "points on the ground alone": side * [1.0, 1.0, 0.0],
        "points at the end of sight": side * [30.0, 1.0, 1.0],
        f"{MANY} points in one cluster": np.vstack([side, rear])[rng.integers(0, 60, MANY)]
        + rng.normal(0.0, 0.03, (MANY, 3)),
    }
    labels = [label for label in kinds for _ in range(4)]
    scans = [Scan.from_points(DT_S * k, kinds[label], (0.1 * k, 0.0, 0.002 * k)) for k, label in enumerate(labels)]
    return CheckDrive("odd scans", tuple(scans), tuple(labels))
