"""The device under test: what the run loop asks of a tracker, and how one is named on the command line."""

import importlib
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any, Protocol

import numpy as np

from scenarios.errors import DeviceError
from sensor_model.truth import ScanTruth
from sim.world import WorldFrame
from tracker.records import StepTrace, Tracks
from tracker.scan import Scan
from tracker.tracker import TrackerConfig

SHIPPED = "tracker.tracker:Tracker"


class Device(Protocol):
    """A tracker. It sees scans only, one at a time, in order; it is made anew for every run.

    `Tracks` of a tracker without a bank of models have one-hot `model_probability` and equal `model_position_odom`.
    Without a `StepTrace` its fits are not graded and `fit.*` does not apply.
    """

    def step(self, scan: Scan) -> Tracks | tuple[Tracks, StepTrace]:
        """Take in one scan and return what is tracked after it."""
        ...


class Oracle(Device, Protocol):
    """A device that is told the truth before each scan: to test the grader with, or to stand in for a stage.

    A tracker has no `see_truth`; the report of a run names its device, so that no oracle passes for one.
    """

    def see_truth(self, frame: WorldFrame, truth: ScanTruth) -> None:
        """Take in the truth of the scan that comes next."""
        ...


DeviceFactory = Callable[[TrackerConfig], Device]
"""Gets the `[tracker]` table of the scenario. It is called once more than there are runs: a throw-away device
compiles what it compiles before the clock starts."""


def load(spec: str) -> DeviceFactory:
    """Import a tracker from `MODULE:NAME`; modules of the current folder count.

    Raises
    ------
    DeviceError
        There is no such module, no such name in it, or it cannot be called.
    """
    module_name, colon, name = spec.partition(":")
    if not (colon and name and module_name) or module_name.startswith("."):
        raise DeviceError(f"--tracker {spec}: should be MODULE:NAME, as in {SHIPPED}")
    here = str(Path.cwd())
    if here not in sys.path:
        sys.path.insert(0, here)
    try:
        module = importlib.import_module(module_name)
    except ModuleNotFoundError as error:
        if error.name is None or not f"{module_name}.".startswith(f"{error.name}."):
            raise  # the module is there, and it is one of its own imports that is not
        raise DeviceError(f"--tracker {spec}: no module {error.name} on the Python path or in {here}") from error
    factory: Any = getattr(module, name, None)
    if not callable(factory):
        problem = "is not callable" if hasattr(module, name) else "is not there"
        raise DeviceError(f"--tracker {spec}: {name} {problem} in {module_name}; name a class with step(scan)")
    return factory  # type: ignore[no-any-return]


def name_of(make_device: DeviceFactory) -> str:
    """`MODULE:NAME` of a class or function; what else makes devices says itself what they are."""
    name = getattr(make_device, "__qualname__", None)
    return f"{make_device.__module__}:{name}" if name else str(make_device)


def tell_truth(device: Device, frame: WorldFrame, truth: ScanTruth) -> None:
    """Let an oracle see the truth of the scan that comes next; trackers hear nothing."""
    see_truth = getattr(device, "see_truth", None)
    if see_truth is not None:
        see_truth(frame, truth)


def step(device: Device, scan: Scan) -> tuple[Tracks, StepTrace | None]:
    """Give the device one scan; the trace is None if it does not tell.

    Raises
    ------
    DeviceError
        It returned something else than tracks, or two tracks of one id, on which no metric has a meaning.
    """
    name = f"{type(device).__module__}:{type(device).__qualname__}"
    trace: StepTrace | None = None
    match device.step(scan):
        case Tracks() as tracks:
            pass
        case (Tracks() as tracks, StepTrace() as trace):
            pass
        case other:
            raise DeviceError(f"{name}.step returned {type(other).__name__}; return Tracks or (Tracks, StepTrace)")
    ids = np.sort(tracks.id)
    if (twice := ids[1:][ids[1:] == ids[:-1]]).size:
        raise DeviceError(
            f"{name}.step gave id {twice[0]} to two tracks of the scan at {scan.time:.2f} s; give each its own "
            "(luxloop check-tracker tells more)"
        )
    return tracks, trace
