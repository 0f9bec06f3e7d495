"""Choose the settings of the league's peers and write them into `scenarios/league/parameters.toml`.

    python docs/tune_league.py FOLDER

All peers have the same budget: `EVALUATIONS` settings each, of which the first are the defaults of the adapter and the
others are drawn at random from the ranges below with a fixed seed. The best one by the mean HOTA of the training runs
is kept. No training scenario is in the league's default list, and no training seed is among its default seeds. The
boxes of the training scans are detected once. FOLDER keeps the recorded scans; a run on two cores takes about ten
minutes.
"""

import math
import statistics
import sys
import zlib
from concurrent.futures import ProcessPoolExecutor
from functools import cache, partial
from pathlib import Path
from typing import Any

import numpy as np

from luxloop.scenarios.files import atomic_file
from luxloop.scenarios.league.drive import SCANS, drives, record
from luxloop.scenarios.league.entrants import Entrant, entrants
from luxloop.scenarios.league.peers import PARAMETERS
from luxloop.scenarios.league.trackers.autoware_fits import AutowareDetector
from luxloop.scenarios.offline.recorded_scans import RecordedRun
from luxloop.scenarios.offline.regrade import Regrader
from luxloop.tracker.detection.detector import Detector
from luxloop.tracker.records import Detection

SCENARIOS, SEEDS, DURATION_S = ("bus-stop", "roundabout-v0", "motorway-exit"), (1, 2, 3), 5.0
EVALUATIONS = 8

Settings = dict[str, Any]
Range = tuple[str, float, float]
"""Kind (`log`, `linear` or `whole`) and both ends."""
HITS: Range = ("whole", 3, 10)
COAST_S: Range = ("log", 0.25, 2.0)
COMMON: dict[str, Range] = {
    "position_std_m": ("log", 0.15, 1.0),
    "gate_sigma": ("linear", 2.5, 6.0),
    "confirm_hits": HITS,
    "coast_s": COAST_S,
}
SOUP: dict[str, Range] = {"acceleration": ("log", 0.5, 30.0), **COMMON}
JOINT: dict[str, Range] = {**SOUP, "detect_probability": ("linear", 0.6, 0.98), "clutter_per_m2": ("log", 1e-4, 0.1)}
RANGES: dict[str, dict[str, Range]] = {
    "nearest-neighbour": SOUP,
    "jpda": JOINT,
    "autoware-bicycle": {
        **COMMON,
        "acceleration_std": ("log", 1.0, 10.0),
        "slip_rate_std": ("log", 0.05, 1.0),
        "heading_std_rad": ("log", 0.03, 0.5),
    },
    "norfair": {
        "distance_m": ("linear", 1.0, 4.0),
        "confirm_hits": HITS,
        "coast_s": COAST_S,
        "measurement_variance": ("log", 0.02, 1.0),
        "process_variance": ("log", 0.001, 0.3),
    },
    "particle-filter": SOUP,
    "multi-hypothesis": JOINT,
}


class Detected:
    """Detector that returns the detections of recorded scans."""

    def __init__(self, run: RecordedRun, kind: type[Detector]) -> None:
        detector = kind(run.scenario.tracker)
        self._by_time: dict[float, Detection] = {scan.time: detector.step(scan) for _, scan, _ in run.scans()}

    def step(self, scan: Any) -> Detection:
        """Return the detection of a scan."""
        return self._by_time[scan.time]


def main(folder: Path) -> None:
    """Record the training scans, tune every peer, and write the file."""
    with ProcessPoolExecutor(2) as pool:
        names = list(pool.map(record, drives(SCENARIOS, SEEDS, DURATION_S, [], folder)))
        found = list(pool.map(partial(tuned, [folder / SCANS / name for name in names]), RANGES))
    with atomic_file.create(PARAMETERS) as temporary:
        temporary.write_text(document(dict(zip(RANGES, found, strict=True))), encoding="utf-8")


def tuned(runs: list[Path], name: str) -> list[tuple[float, Settings]]:
    """Return the mean HOTA and the settings of each evaluation of a peer."""
    entrant = Entrant(name, entrants()[name].place, "")
    rng = np.random.default_rng(zlib.crc32(name.encode()))
    tried: list[Settings] = [{}]
    tried += [{key: drawn(one, rng) for key, one in RANGES[name].items()} for _ in range(EVALUATIONS - 1)]
    return [(mean_hota(entrant, settings, runs), settings) for settings in tried]


def drawn(within: Range, rng: np.random.Generator) -> float:
    """Return a value at random, with three significant digits."""
    kind, low, high = within
    if kind == "whole":
        return int(rng.integers(int(low), int(high) + 1))
    value = math.exp(rng.uniform(math.log(low), math.log(high))) if kind == "log" else rng.uniform(low, high)
    return float(f"{value:.3g}")


def mean_hota(entrant: Entrant, settings: Settings, runs: list[Path]) -> float:
    """Return the mean HOTA of a peer over the training runs."""
    kind = AutowareDetector if entrant.name == "autoware-bicycle" else Detector
    values = []
    for path in runs:
        run, boxes = detected(path, kind)
        device = partial(entrant, make_detector=lambda _config, boxes=boxes: boxes, **settings)
        hota = Regrader(run, run.scenario).tracker(device, entrant.name).metrics["track.hota"].value
        assert hota is not None
        values.append(hota)
    print(f"{entrant.name}: {statistics.fmean(values):.3f} {settings}", flush=True)
    return statistics.fmean(values)


@cache
def detected(path: Path, kind: type[Detector]) -> tuple[RecordedRun, Detected]:
    """Return a recorded run and the detections of its scans."""
    run = RecordedRun.open(path)
    return run, Detected(run, kind)


def document(found: dict[str, list[tuple[float, Settings]]]) -> str:
    """Return the file of settings, with the HOTA of the defaults and of the best settings."""
    lines = [
        f"# Settings of the peers, chosen by docs/tune_league.py: the best of {EVALUATIONS} evaluations each,",
        f"# by the mean HOTA over the first {DURATION_S:g} s of {', '.join(SCENARIOS)},",
        f"# seeds {SEEDS[0]} to {SEEDS[-1]}.",
    ]
    for name, evaluations in found.items():
        best, settings = max(evaluations, key=lambda each: each[0])
        lines += ["", f"[{name}] # HOTA {best:.3f}, with the defaults {evaluations[0][0]:.3f}"]
        lines += [f"{key} = {value!r}" for key, value in settings.items()]
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    main(Path(sys.argv[1]))
