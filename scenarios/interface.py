"""The Python interface, which `import luxloop` names and the command line calls.

Slow packages are imported inside the functions, so that `import luxloop` and `luxloop --help` are fast.
"""

import os
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Union

from luxloop.scenarios.errors import InputError
from luxloop.scenarios.files import input_file, shipped
from luxloop.scenarios.files.settings import plain, texts
from luxloop.scenarios.oracle.stage import Stage

if TYPE_CHECKING:
    from luxloop.scenarios.compare.comparison import Comparison
    from luxloop.scenarios.exchange.paired_frames import BoxLimits, FrameMatching
    from luxloop.scenarios.files.scenario import Scenario
    from luxloop.scenarios.files.shipped import Entry
    from luxloop.scenarios.oracle.ceiling import Ceiling
    from luxloop.scenarios.result import Result
    from luxloop.scenarios.run.device import DeviceFactory

Settings = Mapping[str, object] | Sequence[str]
"""Values by dotted key, as `{"noise.rain.rate_mm_per_h": 3}`, or texts KEY=VALUE as after `--set`."""
Runs = Union[str, Path, "Result", Iterable[Union[str, Path, "Result"]]]
"""A folder of runs, a single run, a baseline file, a result, or several run folders or results."""

STATED_LOSS = 0.02
"""`luxloop.scenarios.compare.comparison.STATED_LOSS`, whose import is slower than the help."""
STEP_TIMEOUT_S = 60.0
"""`luxloop.scenarios.run.process_tracker.STEP_TIMEOUT_S`, without its import."""


def run(
    scenario: "str | Path | Scenario",
    *,
    tracker: "str | DeviceFactory | None" = None,
    oracles: Sequence[str] = (),
    seed: int | None = None,
    duration_s: float | None = None,
    settings: Settings = (),
    out: str | Path | None = None,
    into: str | Path | None = None,
    record: bool = False,
    record_scans: bool = False,
    dataset_to: str | Path | None = None,
    step_timeout_s: float = STEP_TIMEOUT_S,
    ahead: bool | None = None,
    in_process: bool = False,
    progress: bool = False,
) -> "Result":
    """Run a scenario and grade it. Without `out` and `into`, nothing is written.

    Parameters
    ----------
    scenario
        Name of a shipped scenario, path of a .toml file, or a scenario of `load_scenario`.
    tracker
        The device under test: a class or function that takes a `TrackerConfig` and returns an object with
        `step(scan)`, or a text as after `--tracker`. The shipped tracker if left out. A text names code that runs in a
        process of its own; a class or function runs in this one, see `in_process`.
    oracles
        Stages of the shipped tracker to replace by the ground truth, such as "segmentation".
    seed, duration_s
        Seed and simulated time [s], instead of the scenario's.
    settings
        Other values of any keys of the scenario.
    out
        Folder of the run; an earlier run there is replaced.
    into
        Folder that receives the run folder under its default name, such as `ring-seed1`.
    record
        True to write a recording for `luxloop view` into the folder.
    record_scans
        True to keep scans and ground truth in the folder, for `luxloop grade`.
    dataset_to
        New folder of a data set.
    step_timeout_s
        Limit of one step of a tracker in a process of its own [s].
    ahead
        True to compute traffic and scans in another process; None does so if there is a second core. The result is
        the same.
    in_process
        True to run the tracker in this process, for a debugger. It could then reach the ground truth, so the result
        says so, and comparisons refuse it.
    progress
        True to show a progress bar in a terminal.

    Raises
    ------
    luxloop.Error
        Bad input, a simulator that failed before the first frame, or a tracker that broke its contract. Nothing is
        written then.
    """
    if out and into:
        raise InputError("out and into are both given; omit one")
    if not (out or into) and (record or record_scans or dataset_to):
        raise InputError("record, record_scans and dataset_to need the folder of a run; give out or into")
    ahead = cores() > 1 if ahead is None else ahead
    if ahead:
        _start_worker(scenario)
    loaded = _loaded(scenario, seed, duration_s, settings)
    from luxloop.scenarios.execute import default_folder, execute
    from luxloop.scenarios.oracle.oracle_tracker import choose
    from luxloop.scenarios.run import loop
    from luxloop.scenarios.run.progress import hidden

    make_device = choose(tracker, _stages(oracles), in_process)
    with hidden(not progress):
        if not (out or into):
            return loop.run(loaded, make_device, step_timeout_s=step_timeout_s, ahead=ahead)
        return execute(
            loaded,
            make_device,
            Path(out) if out else default_folder(loaded, oracles, tracker, Path(into or "")),
            record=record,
            record_scans=record_scans,
            dataset_to=Path(dataset_to) if dataset_to else None,
            step_timeout_s=step_timeout_s,
            ahead=ahead,
        )


def load_scenario(
    scenario: str | Path, *, seed: int | None = None, duration_s: float | None = None, settings: Settings = ()
) -> "Scenario":
    """Read a shipped scenario by its name, or any scenario file by its path; parameters as `run`.

    Raises
    ------
    luxloop.Error
        There is no such scenario, or a key or value is invalid.
    """
    path = shipped.find(str(scenario))
    input_file.read_toml(path)  # reports a misspelt name or invalid TOML before the slow imports
    from luxloop.scenarios.files.scenario import Scenario

    return Scenario.load(path, _overrides(seed, duration_s), texts(settings))


def list_scenarios(
    *words: str, family: str | None = None, kind: str | None = None, suite: str | None = None
) -> "list[Entry]":
    """Return the shipped scenarios with name, description, duration and file.

    Parameters
    ----------
    words
        Words that name or description must contain.
    family, kind, suite
        Family of scenarios, kind of traffic, and suite.

    Raises
    ------
    luxloop.Error
        There is no such family, kind or suite; the message names the known ones.
    """
    return shipped.chosen(shipped.entries(), words, family=family, kind=kind, suite=suite)


def load_result(folder: str | Path) -> "Result":
    """Read a run back from its folder. Metrics that its file does not hold are computed from its tables.

    Raises
    ------
    luxloop.Error
        The folder holds no run, an incomplete one, or a damaged one.
    """
    from luxloop.scenarios.run import run_folder

    return run_folder.read(Path(folder))


def grade(
    run: str | Path,
    *,
    tracks: str | Path | None = None,
    tracker: str | None = None,
    scenario: str | None = None,
    out: str | Path | None = None,
    step_timeout_s: float = STEP_TIMEOUT_S,
) -> "Result":
    """Grade a run again without simulation, or a recording with true poses.

    Parameters
    ----------
    run
        Folder of a run or of a recording.
    tracks, tracker
        A file of tracks, or a tracker to run on the scans, as after `--tracker`; neither for the run's own tracks, or
        for the shipped tracker on a recording.
    scenario
        Scenario whose `[grading]` and `[expect]` are used, by name or path.
    out
        Folder of the results; if left out, nothing is written.
    step_timeout_s
        As for `run`.

    Raises
    ------
    luxloop.Error
        Bad input, or a tracker that broke its contract.
    """
    from luxloop.scenarios.offline import regrade
    from luxloop.scenarios.offline.recorded_scans import RecordedRun
    from luxloop.scenarios.recordings.graded_recording import grade_recording
    from luxloop.scenarios.recordings.recording import Recording, is_recording
    from luxloop.scenarios.recordings.track_recording import TRACKS

    folder, file = Path(run), Path(tracks) if tracks else None
    if is_recording(folder):
        source: Recording | RecordedRun = Recording(folder)
    elif (folder / TRACKS).is_file():
        raise InputError(
            f"{run}: results of luxloop track; grade the recording: luxloop grade RECORDING --tracks {folder / TRACKS}"
        )
    else:
        source = RecordedRun.open(folder)
    if out:
        source.refuse_to_write_to(Path(out))
    if isinstance(source, Recording):
        result = grade_recording(folder, file, tracker, scenario, step_timeout_s)
    else:
        result = regrade.grade(source, file, tracker, scenario, step_timeout_s)
    return result.save(out) if out else result


def grade_boxes(
    truth: str | Path,
    tracks: str | Path,
    *,
    formats: tuple[str | None, str | None] = (None, None),
    classes: Sequence[str] = (),
    limits: "BoxLimits | None" = None,
    matching: "FrameMatching | None" = None,
) -> "Result":
    """Grade a file of tracks against a file of true boxes.

    Parameters
    ----------
    truth, tracks
        Files, see docs/formats.md.
    formats
        Names of their formats; None recognises one.
    classes
        Classes of the truth to grade; all if left out.
    limits
        Limits of the metrics.
    matching
        Which frames of the two files are the same.

    Raises
    ------
    luxloop.Error
        A file is not valid, or they do not belong together.
    """
    from luxloop.scenarios.exchange import graded_boxes
    from luxloop.scenarios.exchange.paired_frames import BoxLimits

    return graded_boxes.grade(Path(truth), Path(tracks), formats, tuple(classes), limits or BoxLimits(), matching)


def compare(base: Runs, head: Runs, *, loss: float = STATED_LOSS) -> "Comparison":
    """Compare runs of the same scenarios and seeds.

    Parameters
    ----------
    base, head
        The reference, and the runs to judge.
    loss
        Loss to exclude for the verdict "same", as a share.

    Raises
    ------
    luxloop.Error
        A side has no run or a damaged one, no pair of runs can be compared, or the limits of a pair differ.
    """
    from luxloop.scenarios.compare import comparison, run_pairs

    sides = run_pairs.side_of(base, "BASE"), run_pairs.side_of(head, "HEAD")
    pairs = run_pairs.pair(*sides)
    run_pairs.require_same_limits(*sides)
    return comparison.compare(pairs, loss)


def ceiling(
    scenario: "str | Path | Scenario",
    *,
    seeds: Sequence[int] = (),
    duration_s: float | None = None,
    heading_std_deg: float = 1.0,
    position_std_m: float = 0.05,
) -> "list[Ceiling]":
    """Grade the shipped tracker beside an ideal causal tracker on the same scans.

    Parameters
    ----------
    scenario
        As for `run`.
    seeds
        Seeds of the runs; that of the scenario if left out.
    duration_s
        Simulated time [s], instead of the scenario's.
    heading_std_deg, position_std_m
        Errors of the ideal tracker with noise [deg, m].

    Returns
    -------
    list
        HOTA, ceilings and losses of each run.

    Raises
    ------
    luxloop.Error
        Bad input, or a simulator that failed before the first frame.
    """
    loaded = [_loaded(scenario, seed, duration_s, ()) for seed in seeds or (None,)]
    from luxloop.scenarios.oracle.ceiling import measure
    from luxloop.scenarios.oracle.ceiling_tracker import PoseNoise

    return [measure(one, PoseNoise(heading_std_deg, position_std_m)) for one in loaded]


def cores() -> int:
    """Return the number of cores that this process may use; a container may allow fewer than the machine has."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def _loaded(
    scenario: "str | Path | Scenario", seed: int | None, duration_s: float | None, settings: Settings
) -> "Scenario":
    if isinstance(scenario, str | Path):
        return load_scenario(scenario, seed=seed, duration_s=duration_s, settings=settings)
    return scenario.with_keys(_overrides(seed, duration_s), texts(settings))


def _stages(names: Sequence[str]) -> list[Stage]:
    """Return stages by their names."""
    known = [stage.value for stage in Stage]
    for name in names:
        if name not in known:
            raise InputError(f"oracles: {name}: no such stage; give some of {', '.join(known)}")
    return [Stage(name) for name in names]


def _overrides(seed: int | None, duration_s: float | None) -> dict[str, object]:
    """Return the top-level keys of the scenario file that arguments replace."""
    return {key: plain(value) for key, value in {"seed": seed, "duration_s": duration_s}.items() if value is not None}


def _start_worker(scenario: "str | Path | Scenario") -> None:
    """Let the process of traffic and LIDARs import its modules, which take a second, while this one does."""
    if isinstance(scenario, str | Path):
        input_file.read_toml(shipped.find(str(scenario)))  # a misspelt name needs no process
    from luxloop.sim.process.process_source import start_early

    start_early("luxloop.scenarios.run.scan_source")
