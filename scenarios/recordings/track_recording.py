"""A tracker over a recording: the folder of its results.

The folder is that of a run (`luxloop.scenarios.run.run_folder`), which `luxloop view` opens, with two files more:

- `tracks.parquet`: the tracks, in the layout of `luxloop grade --tracks`
- `report.html`: pictures, lives and speeds of the tracks
"""

from contextlib import closing
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from luxloop.scenarios.document import html
from luxloop.scenarios.document.document import Document
from luxloop.scenarios.files import atomic_file, atomic_folder
from luxloop.scenarios.files.expect import Check, check
from luxloop.scenarios.grading.frame_truth import FrameGrade
from luxloop.scenarios.recordings import track_page
from luxloop.scenarios.recordings.graded_recording import Rules, run_tracker
from luxloop.scenarios.recordings.recording import Recording
from luxloop.scenarios.recordings.track_page import Drive, TrackRows
from luxloop.scenarios.report import text
from luxloop.scenarios.rerun_log.recorder import NullRecorder, Recorder
from luxloop.scenarios.result import Result
from luxloop.scenarios.run import run_folder
from luxloop.scenarios.run.device import DeviceFactory
from luxloop.scenarios.run.process_tracker import STEP_TIMEOUT_S
from luxloop.sensor_model.truth import ScanTruth
from luxloop.sim.world import Obstacles, WorldFrame
from luxloop.tracker.records import StepTrace, Tracks
from luxloop.tracker.scan import Scan

TRACKS, PAGE = "tracks.parquet", "report.html"
CONTENTS = {TRACKS, PAGE, run_folder.RESULT, run_folder.REPORT, run_folder.RECORDING, run_folder.TABLES}
OPTION = "--out"


@dataclass(frozen=True, slots=True)
class Tracked:
    """Results of a tracker on a recording."""

    result: Result
    checks: list[Check]
    facts: list[str]
    """Numbers of tracks, and how long they live."""
    report: Document
    """The printed report."""


def track_recording(
    recording: Recording,
    make_device: DeviceFactory,
    rules: Rules,
    name: str,
    out: Path,
    *,
    record: bool = True,
    step_timeout_s: float = STEP_TIMEOUT_S,
) -> Tracked:
    """Run a tracker over a recording and write the folder of its results, which appears as a whole.

    Parameters
    ----------
    recording, make_device, rules, name
        As for `run_tracker`.
    out
        Folder; earlier results there are replaced.
    record
        True to write a recording for the viewer.
    step_timeout_s
        As for `run_tracker`.

    Raises
    ------
    OutputError, ContractError
        A folder cannot be read or written; the tracker failed, took too long, or returned invalid tracks.
    """
    marks = (TRACKS, run_folder.RESULT)
    refuse = partial(atomic_folder.refuse_other_files, marks=marks, contents=CONTENTS, what="luxloop track")
    with atomic_folder.create(out, OPTION, refuse) as folder:
        rows, drive = TrackRows(), Drive()
        recorder: Recorder | NullRecorder = NullRecorder()
        if record:
            walls = Obstacles.from_polygons([], [])
            recorder = Recorder(folder / run_folder.RECORDING, recording.name, walls, frames=len(recording))

        def observe(
            frame: WorldFrame, scan: Scan, truth: ScanTruth, tracks: Tracks, trace: StepTrace | None, grade: FrameGrade
        ) -> None:
            rows.add(frame.index, frame.time, tracks)
            drive.add(frame, scan)
            recorder.log(frame, scan, truth, tracks, trace, grade)

        with closing(recorder):
            result = run_tracker(recording, make_device, rules, name, observe, step_timeout_s)
            recorder.finish()
        checks = check(result.metrics, rules.expect, result.config["device"])
        tracks = rows.table()
        report = track_page.recording_document(recording, result, checks, tracks, out, None)
        with atomic_file.writing(out, OPTION):
            track_page.write(folder / TRACKS, tracks)
            page = html.page(track_page.recording_document(recording, result, checks, tracks, out, drive))
            (folder / PAGE).write_text(page, encoding="utf-8")
        run_folder.write(folder, result, checks, text.as_text(report))
    return Tracked(result, checks, track_page.facts(result, tracks), report)
