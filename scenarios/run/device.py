"""The device under test: its interface to the run loop, and how it is loaded from the command line."""

from collections.abc import Callable
from pathlib import Path
from typing import Any, Protocol

from luxloop.plugins import OWN, PluginError, PluginGroup
from luxloop.scenarios.errors import DeviceError
from luxloop.scenarios.files import expect
from luxloop.scenarios.run import user_code
from luxloop.scenarios.run.process_tracker import PREFIX, ClassFactory, ProcessFactory
from luxloop.scenarios.run.user_code import UserCodeError
from luxloop.sensor_model.truth import ScanTruth
from luxloop.sim.world import WorldFrame
from luxloop.tracker.records import StepTrace, Tracks
from luxloop.tracker.scan import Scan
from luxloop.tracker.tracker import Tracker, TrackerConfig

SHIPPED = expect.SHIPPED
REFERENCE = "shipped"
"""Name of the shipped tracker among `TRACKERS`."""

FORMS = f"MODULE:NAME or FILE.py:NAME, as in {SHIPPED}, or process:COMMAND"


class Device(Protocol):
    """A tracker. It receives scans only, one at a time and in order; every run makes a new one.

    A tracker without motion models returns `Tracks.from_boxes`. Without a `StepTrace` its fits are not graded and
    `fit.*` does not apply. Scans are read-only copies. `luxloop.scenarios.run.guard` checks every output. A tracker
    of the user runs in a process of its own, see `luxloop.scenarios.run.process_tracker`.
    """

    def step(self, scan: Scan) -> Tracks | tuple[Tracks, StepTrace]:
        """Process one scan and return the tracks after it."""
        ...


class Oracle(Device, Protocol):
    """A device that receives the ground truth before each scan: to test the grader, or to replace a stage.

    Only the types in `ORACLES` do. The report names the device of a run, so it cannot be mistaken for a tracker.
    """

    def see_truth(self, frame: WorldFrame, truth: ScanTruth) -> None:
        """Take the ground truth of the next scan."""
        ...


APART = (ProcessFactory, ClassFactory)
"""Factories whose trackers run in processes of their own."""
ORACLES: set[type] = set()
"""All types that receive the ground truth; a subclass of one does not."""


DeviceFactory = Callable[[TrackerConfig], Device] | ProcessFactory | ClassFactory
"""Makes a device from the `[tracker]` table of the scenario. Every run makes two: the first only compiles the kernels
before the clock starts."""


class NoTracks:
    """Device without tracks, to record scans, or to compile the kernels of traffic and sensor alone."""

    def __init__(self, _config: TrackerConfig) -> None: ...

    def step(self, _scan: Scan) -> Tracks:
        """Return no tracks."""
        return Tracks.from_boxes([], [], [], [])


def _wanted(_name: str, found: Any) -> str:
    return "" if callable(found) else "a class or function that takes a TrackerConfig"


TRACKERS = PluginGroup("luxloop.trackers", _wanted, core={REFERENCE: Tracker})
"""Trackers by name, each a `DeviceFactory`."""


def load(spec: str, in_process: bool = False) -> DeviceFactory:
    """Return the factory of a tracker by `MODULE:NAME`, `FILE.py:NAME`, `process:COMMAND`, or one of `TRACKERS`.

    Code that does not ship with luxloop runs in a process of its own, unless a debugger needs it in this one.
    `MODULE` may be in the current folder, `FILE.py` may import modules of its own folder. Both folders are searched
    after all installed packages.

    Raises
    ------
    DeviceError
        The module or file does not exist or cannot be imported, has no such name, or the name cannot be called.
    """
    if spec.startswith(PREFIX):
        return ProcessFactory(spec.removeprefix(PREFIX))
    if is_name(spec):
        return _load_plugin(spec)
    place, _, name = spec.rpartition(":")
    is_file = place.endswith(".py")
    if not (place and name) or (place.startswith(".") and not is_file):
        raise DeviceError(f"--tracker {spec}: should be {FORMS}")
    if is_file and not Path(place).is_file():
        raise DeviceError(f"--tracker {spec}: no file {place}; give the path of a Python file")
    if not in_process and not place.startswith(f"{OWN}."):
        return ClassFactory(spec)
    try:
        return user_code.load(spec, Path.cwd())  # type: ignore[no-any-return]
    except UserCodeError as error:
        raise DeviceError(f"--tracker {spec}: {error}") from error


def is_name(spec: str) -> bool:
    """Return True for the name of a plug-in, which has no colon."""
    return ":" not in spec and not spec.startswith(".")


def factory_of(tracker: str | DeviceFactory | None, in_process: bool = False) -> DeviceFactory:
    """Return the factory of a tracker: a class or function as it is, a text as `load` reads it, else the shipped one.

    Raises
    ------
    DeviceError
        As `load`, or an object that is no class or function.
    """
    if tracker is None or isinstance(tracker, str):
        return load(tracker or SHIPPED, in_process)
    if not (callable(tracker) or isinstance(tracker, APART)):
        kind = type(tracker).__name__
        raise DeviceError(
            f"tracker: a {kind} cannot be called; give a class or a function that makes it, as lambda config: ..."
        )
    return tracker


def is_in_process(make_device: DeviceFactory) -> bool:
    """Return True if code of the user runs in this process, where it could reach truth and grading."""
    module = getattr(make_device, "__module__", "")
    return not isinstance(make_device, APART) and not module.startswith(f"{OWN}.")


def absolute(spec: str) -> str:
    """Return `FILE.py:NAME` and `process:FILE` with absolute paths, for workers that run elsewhere."""
    if spec.startswith(PREFIX):
        return str(ProcessFactory(spec.removeprefix(PREFIX)))
    place, colon, name = spec.rpartition(":")
    return f"{Path(place).absolute()}{colon}{name}" if place.endswith(".py") else spec


def name_of(make_device: DeviceFactory) -> str:
    """Return `MODULE:NAME` or `FILE.py:NAME` of a class or function, or else the text of the factory itself."""
    name = getattr(make_device, "__qualname__", None)
    if name is None:
        return str(make_device)
    return f"{user_code.place_named(make_device.__module__)}:{name}"


def short_name(spec: str) -> str:
    """Return the name of a class or function without its module or file, or of the program without its folder."""
    if spec.startswith(PREFIX):
        words = spec.removeprefix(PREFIX).split()
        return Path(words[0]).name if words else PREFIX
    return spec.rpartition(":")[2]


def show_truth(device: Device, frame: WorldFrame, truth: ScanTruth) -> None:
    """Pass the ground truth of the next scan to an oracle; a tracker does not receive it."""
    if type(device) in ORACLES:
        device.see_truth(frame, truth)  # type: ignore[attr-defined]


def _load_plugin(name: str) -> DeviceFactory:
    if name not in TRACKERS.names():
        raise DeviceError(f"--tracker {name}: should be {FORMS}, or one of {', '.join(TRACKERS.names())}")
    try:
        if name not in TRACKERS.core and not TRACKERS.place(name).startswith(f"{OWN}."):
            return _of_other_package(name)
        factory: DeviceFactory = TRACKERS.load(name)
    except PluginError as error:
        raise DeviceError(f"--tracker {name}: {error}") from error
    return factory


def _of_other_package(name: str) -> ClassFactory:
    place = TRACKERS.place(name)
    try:
        return ClassFactory(place)
    except DeviceError as error:
        raise TRACKERS.unusable(name, str(error).removeprefix(f"--tracker {place}: ")) from error
