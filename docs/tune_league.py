"""Choose the settings of the league's peers and write them into `scenarios/league/parameters.toml`.

    python docs/tune_league.py FOLDER

All peers have the same budget: `EVALUATIONS` settings each, of which the first are the defaults of the adapter and the
others are drawn at random from the ranges below with a fixed seed. The best one by the mean HOTA of the training runs
is kept. No training scenario is in the league's default list, and no training seed is among its default seeds.
FOLDER keeps the recorded scans; a run on two cores takes about a quarter of an hour.
"""

import math
import statistics
import sys
import zlib
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from luxloop.scenarios.files import atomic_file
from luxloop.scenarios.league.drive import SCANS, drives, record
from luxloop.scenarios.league.entrants import Entrant, entrants
from luxloop.scenarios.league.peers import PARAMETERS
from luxloop.scenarios.offline.recorded_scans import RecordedRun
from luxloop.scenarios.offline.regrade import Regrader

SCENARIOS, SEEDS, DURATION_S = ("bus-stop", "roundabout-v0", "motorway-exit"), (1, 2, 3), 5.0
EVALUATIONS = 8

Settings = dict[str, Any]
RANGES: dict[str, tuple[str, float, float]] = {
    "acceleration": ("log", 0.5, 30.0),
    "acceleration_std": ("log", 1.0, 10.0),
    "clutter_per_m2": ("log", 1e-4, 0.1),
    "coast_s": ("log", 0.25, 2.0),
    "confirm_hits": ("whole", 3, 10),
    "detect_probability": ("linear", 0.6, 0.98),
    "distance_m": ("linear", 1.0, 4.0),
    "gate_sigma": ("linear", 2.5, 6.0),
    "heading_std_rad": ("log", 0.03, 0.5),
    "measurement_variance": ("log", 0.02, 1.0),
    "position_std_m": ("log", 0.15, 1.0),
    "process_variance": ("log", 0.001, 0.3),
    "slip_rate_std": ("log", 0.05, 1.0),
}
"""Kind of the distribution and both ends."""
COMMON = ("position_std_m", "gate_sigma", "confirm_hits", "coast_s")
SOUP = ("acceleration", *COMMON)
JOINT = (*SOUP, "detect_probability", "clutter_per_m2")
KEYS = {
    "nearest-neighbour": SOUP,
    "jpda": JOINT,
    "autoware-bicycle": (*COMMON, "acceleration_std", "slip_rate_std", "heading_std_rad"),
    "norfair": ("distance_m", "confirm_hits", "coast_s", "measurement_variance", "process_variance"),
    "particle-filter": SOUP,
    "multi-hypothesis": JOINT,
}
"""Settings of each peer, in the order in which they are drawn."""


def main(folder: Path) -> None:
    """Record the training scans, tune every peer, and write the file."""
    with ProcessPoolExecutor(2) as pool:
        names = list(pool.map(record, drives(SCENARIOS, SEEDS, DURATION_S, [], folder)))
        found = list(pool.map(partial(tuned, [folder / SCANS / name for name in names]), KEYS))
    with atomic_file.create(PARAMETERS) as temporary:
        temporary.write_text(document(dict(zip(KEYS, found, strict=True))), encoding="utf-8")


def tuned(runs: list[Path], name: str) -> list[tuple[float, Settings]]:
    """Return the mean HOTA and the settings of each evaluation of a peer."""
    entrant = Entrant(name, entrants()[name].place, "")
    rng = np.random.default_rng(zlib.crc32(name.encode()))
    tried = [{}, *({key: drawn(key, rng) for key in KEYS[name]} for _ in range(EVALUATIONS - 1))]
    return [(mean_hota(entrant, settings, runs), settings) for settings in tried]


def drawn(key: str, rng: np.random.Generator) -> float:
    """Return a value of a setting at random, with three significant digits."""
    kind, low, high = RANGES[key]
    if kind == "whole":
        return int(rng.integers(int(low), int(high) + 1))
    value = math.exp(rng.uniform(math.log(low), math.log(high))) if kind == "log" else rng.uniform(low, high)
    return float(f"{value:.3g}")


def mean_hota(entrant: Entrant, settings: Settings, runs: list[Path]) -> float:
    """Return the mean HOTA of a peer over the training runs."""
    values = []
    for run in map(RecordedRun.open, runs):
        graded = Regrader(run, run.scenario).tracker(partial(entrant, **settings), entrant.name)
        values.append(graded.metrics["track.hota"].value)
    print(f"{entrant.name}: {statistics.fmean(values):.3f} {settings}", flush=True)
    return statistics.fmean(values)


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
