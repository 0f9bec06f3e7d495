"""A run from scenario file to result folder, shared by `luxloop run`, pytest, blame and sweeps."""

import hashlib
import re
from collections.abc import Sequence
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path

from luxloop.scenarios.dataset import writer as dataset
from luxloop.scenarios.dataset.writer import DatasetWriter
from luxloop.scenarios.files.scenario import Scenario
from luxloop.scenarios.grading.frame_truth import FrameGrade
from luxloop.scenarios.result import Result
from luxloop.scenarios.run import loop, run_folder
from luxloop.scenarios.run.device import SHIPPED, DeviceFactory, name_of, short_name
from luxloop.scenarios.run.process_tracker import STEP_TIMEOUT_S
from luxloop.sensor_model.truth import ScanTruth
from luxloop.sim.world import Obstacles, WorldFrame
from luxloop.tracker.scan import Scan

LONGEST_PART = 48
"""Characters of a tracker's name or of a setting in the name of a default folder."""


def default_folder(
    scenario: Scenario,
    oracles: Sequence[str] = (),
    tracker: str | DeviceFactory | None = None,
    runs: Path = Path("runs"),
) -> Path:
    """Return the default folder of a run; runs with oracles, another tracker or settings have folders of their own."""
    oracle = ["oracle", *oracles] if oracles else []
    tracker = tracker if tracker is None or isinstance(tracker, str) else name_of(tracker)
    other = [] if tracker in (None, SHIPPED) else [file_name(short_name(tracker))]
    return runs / "-".join(
        [f"{scenario.name}-seed{scenario.seed}", *oracle, *other, *map(file_name, scenario.settings)]
    )


def file_name(text: str) -> str:
    """Return a text as part of a file name; one that had to be changed gets a digest, so that names stay different."""
    plain = re.sub(r"[^\w.=+-]+", "-", text)[:LONGEST_PART]
    return plain if plain == text else f"{plain}-{hashlib.blake2b(text.encode(), digest_size=3).hexdigest()}"


def execute(
    scenario: Scenario,
    make_device: DeviceFactory,
    out: Path,
    *,
    record: bool = True,
    record_scans: bool = False,
    dataset_to: Path | None = None,
    step_timeout_s: float = STEP_TIMEOUT_S,
    ahead: bool = False,
) -> Result:
    """Run a scenario, grade it, and write its folder, which is `out` of the result.

    Parameters
    ----------
    scenario, make_device
        As `luxloop.scenarios.run.loop.run`.
    out
        Folder of the run; replaces an earlier run there.
    record
        True to write a recording.
    record_scans
        True to keep the scans and their ground truth in the folder, as a data set, for `luxloop grade`.
    dataset_to
        Folder of a further data set, see `luxloop.scenarios.dataset.writer`.
    step_timeout_s, ahead
        As `luxloop.scenarios.run.loop.run`.

    Raises
    ------
    OutputError
        A folder cannot be written, or holds other files and is not replaced.
    Exception
        As `luxloop.scenarios.run.loop.run`; nothing is written then.
    """
    with ExitStack() as stack:
        folder = stack.enter_context(run_folder.create(out))
        writers: list[DatasetWriter] = []
        if dataset_to:
            writers.append(stack.enter_context(dataset.create(dataset_to, out)))
        if record_scans:
            writers.append(stack.enter_context(run_folder.scans(folder)))

        def start(obstacles: Obstacles) -> None:
            for writer in writers:
                writer.start(obstacles)

        def export(frame: WorldFrame, scan: Scan, truth: ScanTruth, grade: FrameGrade) -> None:
            for writer in writers:
                writer.add(frame, scan, truth, grade)

        record_to = folder / run_folder.RECORDING if record else None
        result = loop.run(scenario, make_device, record_to, export if writers else None, step_timeout_s, start, ahead)
        for writer in writers:
            writer.finish(result)
        run_folder.write(folder, result, result.checks, result.report())
    return replace(result, out=out)
