"""Grading of a recording with true poses: a tracker, or a file of tracks."""

from pathlib import Path

from luxloop.scenarios.errors import InputError
from luxloop.scenarios.files.expect import Check, check
from luxloop.scenarios.offline.track_file import TrackFile
from luxloop.scenarios.recordings.graded_recording import grade_device, run_tracker
from luxloop.scenarios.recordings.recording import Recording
from luxloop.scenarios.recordings.recording_rules import rules_of
from luxloop.scenarios.result import Result
from luxloop.scenarios.run import device
from luxloop.scenarios.run.containment import STEP_TIMEOUT_S
from luxloop.scenarios.run.guard import guarded


def grade_recording(
    folder: Path,
    tracks: Path | None,
    tracker: str | None,
    scenario: str | None,
    step_timeout_s: float = STEP_TIMEOUT_S,
) -> tuple[Result, list[Check]]:
    """Grade tracks on a recording, or a tracker; without either, the shipped tracker.

    Parameters
    ----------
    folder
        Folder of the recording.
    tracks
        File of tracks, see docs/other-trackers.md.
    tracker
        `MODULE:NAME` of a tracker.
    scenario
        Scenario whose settings are used, by name or path.
    step_timeout_s
        Limit of one step of the tracker [s].

    Raises
    ------
    InputError
        The recording has no true poses or is damaged, or the tracks do not fit it.
    """
    recording = Recording(folder)
    if not recording.has_truth:
        raise InputError(f"{folder}: has no true poses to grade by; import it with --truth, or use luxloop track")
    rules = rules_of(recording, scenario)
    if tracks:
        with guarded(TrackFile(tracks, recording.time_s).as_device, rules.tracker) as device_of_file:
            result = grade_device(recording, device_of_file, rules, str(tracks), timed=False)
    else:
        name = tracker or device.SHIPPED
        result = run_tracker(recording, device.load(name), rules, name, step_timeout_s=step_timeout_s)
    return result, check(result.metrics, rules.expect, result.config["device"])
