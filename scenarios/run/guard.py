"""A tracker under guard: it gets copies of the scans, and its output is copied and checked in every frame."""

import errno
import gc
import os
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import fields, replace
from pathlib import Path
from typing import Any, NoReturn

import numpy as np

from luxloop.scenarios.errors import ContractError, InputError
from luxloop.scenarios.run import containment, device, process_tracker
from luxloop.scenarios.run.containment import (
    STEP_TIMEOUT_S,
    ForkMark,
    StepTimeoutError,
    Watch,
    call_restored,
    contained,
    watched,
)
from luxloop.scenarios.run.device import Device, DeviceFactory
from luxloop.scenarios.run.output_checks import (
    SHAPES,
    Faults,
    check_covariances,
    check_shapes,
    check_trace,
    check_trace_shapes,
    check_values,
)
from luxloop.scenarios.run.process_tracker import ProcessTracker, TrackerProcessError
from luxloop.scenarios.run.termination import in_main_thread
from luxloop.sensor_model.truth import ScanTruth
from luxloop.sim.world import WorldFrame
from luxloop.tracker.records import Boxes, Candidates, Linkage, Segments, StepTrace, Tracks
from luxloop.tracker.scan import Scan
from luxloop.tracker.tracker import TrackerConfig

TRACKS_MAX = 10_000
"""Largest number of tracks in a frame: grading compares all pairs of tracks and vehicles."""
THREADS_END_S = 1.0
"""Time for a tracker's threads to end after its last step [s]."""
MORE = "luxloop check-tracker shows more"
HARNESS = (__file__, containment.__file__, process_tracker.__file__)
"""Files that are never the place of a tracker's error."""
RECORDS = (Tracks, StepTrace, Segments, Linkage, Candidates, Boxes)
TYPES = {"id": np.int64, "status": np.uint8, "model": np.int64, "corner_sign": np.int64, "small": np.bool_}
"""Types of the integer and boolean fields of `Tracks` in the harness; all others are float64."""

Output = object
"""Return value of a tracker's `step`, not yet checked."""


class Guard:
    """A tracker, and the index of its next frame.

    Parameters
    ----------
    make_device
        Makes the tracker.
    config
        The scenario's `[tracker]` table.
    limit_s
        Limit of one call [s].
    phase
        Prefix of frames in messages, for the warm-up.

    Raises
    ------
    ContractError
        The tracker cannot be made.
    """

    def __init__(self, make_device: DeviceFactory, config: TrackerConfig, limit_s: float, phase: str = "") -> None:
        self._name, self._limit_s, self._phase = device.name_of(make_device), limit_s, phase
        self._frame, self._time = -1, 0.0
        self._forks, self._threads = ForkMark(), set[threading.Thread]()
        self._models: tuple[str, ...] | None = None
        self._process: ProcessTracker | None = None
        self._device: Device | None = self._call(make_device, config)
        self._process = self._device if isinstance(self._device, ProcessTracker) else None
        if self._process:
            self._process.limit_s = limit_s
        self._own = type(self._device).__module__.partition(".")[0] == "luxloop"

    def show_truth(self, frame: WorldFrame, truth: ScanTruth) -> None:
        """Pass the ground truth of the next scan to an oracle."""
        assert self._device is not None
        device.show_truth(self._device, frame, truth)

    def step(self, scan: Scan) -> Output:
        """Pass a copy of a scan to the tracker and return its output, which `checked` must see before use.

        Raises
        ------
        ContractError
            The tracker raised an exception, tried to end the process, or exceeded the time limit.
        """
        assert self._device is not None
        self._frame, self._time = self._frame + 1, scan.time
        return self._call(_step, self._device, read_only(scan))

    def checked(self, output: Output, scan: Scan) -> tuple[Tracks, StepTrace | None]:
        """Return copies of the tracks and the trace of the last step; the trace is None if there is none.

        Raises
        ------
        ContractError
            They break the contract; the message names the frame and the field.
        """
        trace: StepTrace | None = None
        match output:
            case Tracks() as tracks:
                pass
            case (Tracks() as tracks, StepTrace() as trace):
                pass
            case other:
                self._break(f"returned {type(other).__name__}; return Tracks or (Tracks, StepTrace)")
        try:
            return self._checked_tracks(tracks), self._checked_trace(trace, scan) if trace else None
        except ContractError:
            raise
        except (Exception, SystemExit) as error:  # fields are missing, or properties that fail
            self._break(f"returned a record that cannot be read ({type(error).__name__}: {error}); {MORE}", error)

    def finish(self) -> None:
        """Check, after the last step, that neither a thread nor a forked copy of the run is left.

        Raises
        ------
        ContractError
            One is left.
        """
        if self._process:
            self._call(self._process.finish)
        self._device = None
        if self._threads:
            gc.collect()  # idle workers of an executor end with it
        for thread in self._threads:
            thread.join(THREADS_END_S / len(self._threads))
        left = sorted(thread.name for thread in self._threads if thread.is_alive())
        if left:
            self._break(f"left the thread {left[0]} running after the last frame; end it, or make it a daemon")
        self._check_forks()

    def close(self) -> None:
        """End the process of a tracker that has one."""
        if self._process:
            self._process.close()

    def _checked_tracks(self, tracks: Tracks) -> Tracks:
        if len(np.shape(tracks.id)) == 1 and len(tracks.id) > TRACKS_MAX:
            self._break(f"id: {len(tracks.id)} tracks; at most {TRACKS_MAX} can be graded")
        self._require(check_shapes(tracks))
        copy: Tracks = _copied(tracks)
        self._require(check_values(copy))
        self._require(check_covariances(copy, definite=False))
        if tracks.models != (self._models or tracks.models):
            self._break(f"models is {tracks.models}, but was {self._models} before; keep one order in all frames")
        self._models = copy.models
        return replace(copy, **{name: _converted(name, getattr(copy, name)) for name in SHAPES})

    def _checked_trace(self, trace: StepTrace, scan: Scan) -> StepTrace:
        self._require(check_trace_shapes(trace))
        copy: StepTrace = _copied(trace)
        self._require(check_trace(copy, scan))
        return copy

    def _require(self, faults: Faults) -> None:
        for fault in faults:
            self._break(f"{fault.what}; {MORE}")

    def _call(self, call: Callable[..., Any], *arguments: Any) -> Any:
        """Call into the tracker, and turn anything that it raises into one line."""
        threads, folder = set(threading.enumerate()), Path.cwd()
        watch = Watch()
        try:
            with watched(self._limit_s, self._line(self._timeout())) as watch, call_restored():
                value = call(*arguments)
        except BaseException as error:
            self._forks.leave_if_copy()
            self._raise(error, watch)
        self._forks.leave_if_copy()
        if watch.interrupted:
            raise KeyboardInterrupt
        if watch.alarms:
            self._break(self._timeout())
        if in_main_thread():
            self._threads |= {thread for thread in set(threading.enumerate()) - threads if not thread.daemon}
        self._check_folder(folder)
        self._check_forks()
        return value

    def _raise(self, error: BaseException, watch: Watch) -> NoReturn:
        """Raise the error that a run ends with: Ctrl-C, an error of luxloop itself, or a broken contract."""
        if watch.interrupted:
            raise KeyboardInterrupt from error
        if isinstance(error, TrackerProcessError):
            self._break(str(error), error)
        place = device.place_of(error, apart_from=HARNESS)
        if isinstance(error, StepTimeoutError) or watch.alarms:  # numba makes other errors of a late compilation
            self._break(f"{place}{self._timeout()}", error)
        made = getattr(self, "_device", None) is not None
        if isinstance(error, Exception) and (self._own if made else isinstance(error, InputError)):
            raise error
        if isinstance(error, OSError) and error.errno == errno.ENOSPC:  # a full disk is the fault of no tracker
            raise error
        reason = f"{type(error).__name__}: {error}".rstrip(": ")
        self._break(f"{place}raised {reason}", error)

    def _check_folder(self, folder: Path) -> None:
        with suppress(FileNotFoundError):
            now = Path.cwd()
            if now != folder:
                os.chdir(folder)
                self._break(f"changed the current folder to {now}; use absolute paths")
            return
        self._break(f"removed the current folder {folder}")

    def _check_forks(self) -> None:
        if self._forks.set:
            self._break("forked the run, and the copy returned; end it with os._exit, or use multiprocessing")

    def _timeout(self) -> str:
        return f"took more than {self._limit_s:g} s; raise the limit of a step with --step-timeout"

    def _line(self, what: str) -> str:
        if self._frame < 0:
            return f"{self._name}: {self._phase}start: {what}"
        step = "" if self._process else ".step"
        return f"{self._name}{step}: {self._phase}frame {self._frame} at {self._time:.2f} s: {what}"

    def _break(self, what: str, error: BaseException | None = None) -> NoReturn:
        raise ContractError(" ".join(self._line(what).split())) from error


@contextmanager
def guarded(
    make_device: DeviceFactory, config: TrackerConfig, limit_s: float = STEP_TIMEOUT_S, phase: str = ""
) -> Iterator[Guard]:
    """Make a tracker and yield it under guard; parameters and errors as `Guard`."""
    with contained():
        guard = Guard(make_device, config, limit_s, phase)
        try:
            yield guard
            guard.finish()
        finally:
            guard.close()


def _step(tracker: Device, scan: Scan) -> Output:
    return tracker.step(scan)


def read_only(scan: Scan) -> Scan:
    """Return a copy of a scan whose arrays refuse to be written to."""
    copies: dict[str, Any] = {name: _copied(getattr(scan, name)) for name in fields_of(scan)}
    for value in copies.values():
        if isinstance(value, np.ndarray):
            value.setflags(write=False)
    return Scan(**copies)


def fields_of(record: Any) -> list[str]:
    """Return the names of the fields of a record."""
    return [field.name for field in fields(record)]


def _converted(name: str, array: Any) -> Any:
    """Return a field of `Tracks` in the harness's type."""
    return None if array is None else array.astype(TYPES.get(name, np.float64), copy=False)


def _copied(value: Any) -> Any:
    """Return a deep copy of a record, as one of `RECORDS`; subclasses of records and arrays become these."""
    if isinstance(value, np.ndarray):
        return np.array(value)
    for record in RECORDS:
        if isinstance(value, record):
            return record(**{name: _copied(getattr(value, name)) for name in fields_of(record)})
    return value
