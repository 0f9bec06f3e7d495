"""A tracker under guard: it gets copies of the scans, and its output is copied and checked in every frame."""

from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from itertools import islice
from typing import Any, NoReturn

from luxloop.scenarios.errors import ContractError, InputError
from luxloop.scenarios.run import device, progress
from luxloop.scenarios.run.child_process import ChildError, ChildTimeoutError
from luxloop.scenarios.run.device import APART, Device, DeviceFactory
from luxloop.scenarios.run.output_checks import BrokenOutputError, OutputCheck, read_only
from luxloop.scenarios.run.process_tracker import START_FACTOR, STEP_TIMEOUT_S, ProcessTracker, TrackerProcess
from luxloop.scenarios.run.termination import is_interrupt
from luxloop.scenarios.run.user_code import place_of, reason_of
from luxloop.scenarios.run.warm_up import FRAMES, compilation_reported
from luxloop.sensor_model.truth import ScanTruth
from luxloop.sim.world import WorldFrame
from luxloop.tracker.records import StepTrace, Tracks
from luxloop.tracker.scan import Scan
from luxloop.tracker.tracker import TrackerConfig

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
        Limit of one step of a tracker in a process of its own [s]; its start, and steps of the warm-up, may take
        `START_FACTOR` times as long. One in this process has none.
    phase
        Prefix of frames in messages, for the warm-up.

    Raises
    ------
    ContractError
        The tracker cannot be made.
    """

    def __init__(self, make_device: DeviceFactory, config: TrackerConfig, limit_s: float, phase: str = "") -> None:
        self._name, self._phase = device.name_of(make_device), phase
        self._limit_s = START_FACTOR * limit_s
        self._frame, self._time = -1, 0.0
        self._check = OutputCheck()
        self._process: TrackerProcess | None = None
        self._own = not device.is_in_process(make_device)
        self._device: Device | TrackerProcess
        if isinstance(make_device, APART):
            self._device = self._process = self._call(make_device.start, config, self._limit_s)
            self._process.limit_s = self._limit_s = self._limit_s if phase else limit_s
        else:
            self._device = self._call(make_device, config)

    def show_truth(self, frame: WorldFrame, truth: ScanTruth) -> None:
        """Pass the ground truth of the next scan to an oracle."""
        device.show_truth(self._device, frame, truth)

    def step(self, scan: Scan) -> Output:
        """Pass a copy of a scan to the tracker and return its output, which `checked` must see before use.

        Raises
        ------
        ContractError
            The tracker raised an exception, ended its process, or exceeded the time limit.
        """
        self._frame, self._time = self._frame + 1, scan.time
        return self._call(lambda: self._device.step(scan if self._process else read_only(scan)))

    def checked(self, output: Output, scan: Scan) -> tuple[Tracks, StepTrace | None]:
        """Return copies of the tracks and the trace of the last step; the trace is None if there is none.

        Raises
        ------
        ContractError
            They break the contract; the message names the frame and the field.
        """
        try:
            return self._check.checked(output, scan)
        except BrokenOutputError as error:
            self._break(str(error), error)

    def finish(self) -> None:
        """End a tracker in a process of its own after the last step.

        Raises
        ------
        ContractError
            It does not end.
        """
        if self._process:
            self._call(self._process.finish)

    def close(self) -> None:
        """Kill the process of a tracker that has one."""
        if self._process:
            self._process.close()

    def _call(self, call: Callable[..., Any], *arguments: Any) -> Any:
        """Call into the tracker, and turn what it raises into one line."""
        try:
            return call(*arguments)
        except ChildError as error:
            self._break(str(error), error)
        except ChildTimeoutError as error:
            self._break(f"took more than {self._limit_s:g} s; raise the limit of a step with --step-timeout", error)
        except BaseException as error:
            if is_interrupt(error) or self._own or (self._frame < 0 and isinstance(error, InputError)):
                raise
            self._break(f"{place_of(error, (__file__,))}raised {reason_of(error)}", error)

    def _line(self, what: str) -> str:
        if self._frame < 0:
            return f"{self._name}: {self._phase}start: {what}"
        step = "" if isinstance(self._process, ProcessTracker) else ".step"
        return f"{self._name}{step}: {self._phase}frame {self._frame} at {self._time:.2f} s: {what}"

    def _break(self, what: str, error: BaseException | None = None) -> NoReturn:
        raise ContractError(" ".join(self._line(what).split())) from error


def warm_up(
    make_device: DeviceFactory,
    config: TrackerConfig,
    name: str,
    frames: Iterable[tuple[WorldFrame, Scan, ScanTruth]],
    step_timeout_s: float = STEP_TIMEOUT_S,
) -> None:
    """Run a tracker that is not used again on the first frames, to compile its kernels before the time is measured.

    Parameters
    ----------
    make_device, config
        As `Guard`.
    name
        What is run, for the progress.
    frames
        Frames with their scans and truth; a few are taken.
    step_timeout_s
        As `limit_s` of `Guard`.

    Raises
    ------
    ContractError
        As `Guard`.
    """
    with (
        progress.start(name) as report,
        compilation_reported(report),
        guarded(make_device, config, step_timeout_s, "warm-up, ") as unused,
    ):
        for frame, scan, truth in islice(frames, FRAMES):
            unused.show_truth(frame, truth)
            unused.checked(unused.step(scan), scan)


@contextmanager
def guarded(
    make_device: DeviceFactory, config: TrackerConfig, limit_s: float = STEP_TIMEOUT_S, phase: str = ""
) -> Iterator[Guard]:
    """Make a tracker and yield it under guard; parameters and errors as `Guard`."""
    guard = Guard(make_device, config, limit_s, phase)
    try:
        yield guard
        guard.finish()
    finally:
        guard.close()
