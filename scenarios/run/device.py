"""The device under test: its interface to the run loop, and how it is loaded from the command line."""

import hashlib
import importlib
import importlib.util
import sys
import sysconfig
import traceback
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from types import ModuleType
from typing import Any, Protocol

from luxloop import former_names
from luxloop.plugins import PluginError, PluginGroup
from luxloop.scenarios.errors import DeviceError
from luxloop.scenarios.run.containment import contained
from luxloop.scenarios.run.process_tracker import PREFIX, ProcessFactory
from luxloop.sensor_model.truth import ScanTruth
from luxloop.sim.world import WorldFrame
from luxloop.tracker.records import StepTrace, Tracks
from luxloop.tracker.scan import Scan
from luxloop.tracker.tracker import Tracker, TrackerConfig

SHIPPED = "luxloop.tracker.tracker:Tracker"
REFERENCE = "shipped"
"""Name of the shipped tracker among `TRACKERS`."""

FORMS = f"MODULE:NAME or FILE.py:NAME, as in {SHIPPED}, or process:COMMAND"

_file_of_module: dict[str, Path] = {}
"""Files that trackers were loaded from, by the name of the module made of each."""


class Device(Protocol):
    """A tracker. It receives scans only, one at a time and in order; every run makes a new one.

    A tracker without motion models returns `Tracks.from_boxes`. Without a `StepTrace` its fits are not graded and
    `fit.*` does not apply. Scans are read-only copies. `luxloop.scenarios.run.guard` checks every output.
    """

    def step(self, scan: Scan) -> Tracks | tuple[Tracks, StepTrace]:
        """Process one scan and return the tracks after it."""
        ...


class Oracle(Device, Protocol):
    """A device that receives the ground truth before each scan: to test the grader, or to replace a stage.

    A tracker has no `see_truth`. The report names the device of a run, so an oracle cannot be mistaken for a tracker.
    """

    def see_truth(self, frame: WorldFrame, truth: ScanTruth) -> None:
        """Take the ground truth of the next scan."""
        ...


DeviceFactory = Callable[[TrackerConfig], Device]
"""Makes a device from the `[tracker]` table of the scenario. Every run calls it twice: the first device only compiles
the kernels before the clock starts."""


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


def load(spec: str) -> DeviceFactory:
    """Import a tracker from `MODULE:NAME` or `FILE.py:NAME`, start `process:COMMAND`, or take one of `TRACKERS`.

    `MODULE` may be in the current folder, `FILE.py` may import modules of its own folder. Both folders are searched
    after all installed packages.

    Raises
    ------
    DeviceError
        The module or file does not exist or cannot be imported, has no such name, or the name cannot be called; or it
        is an oracle, whose figures would be taken for a tracker's.
    """
    if spec.startswith(PREFIX):
        return ProcessFactory(spec.removeprefix(PREFIX))
    if is_name(spec):
        return _load_plugin(spec)
    place, _, name = spec.rpartition(":")
    is_file = place.endswith(".py")
    if not (place and name) or (place.startswith(".") and not is_file):
        raise DeviceError(f"--tracker {spec}: should be {FORMS}")
    module = _load_file(Path(place), spec) if is_file else _load_module(place, spec)
    factory: Any = getattr(module, name, None)
    if not callable(factory):
        problem = "is not callable" if hasattr(module, name) else "is not there"
        raise DeviceError(f"--tracker {spec}: {name} {problem} in {place}; name a class with step(scan)")
    _refuse_oracle(factory, f"--tracker {spec}")
    return factory  # type: ignore[no-any-return]


def is_name(spec: str) -> bool:
    """Return True for the name of a plug-in, which has no colon."""
    return ":" not in spec and not spec.startswith(".")


def _refuse_oracle(factory: object, named: str) -> None:
    if hasattr(factory, "see_truth"):
        raise DeviceError(f"{named}: see_truth would receive the ground truth; a tracker has no such method")


def factory_of(tracker: str | DeviceFactory | None) -> DeviceFactory:
    """Return the factory of a tracker: a class or function as it is, a text as `load` reads it, else the shipped one.

    Raises
    ------
    DeviceError
        As `load`, or an object that is no class or function.
    """
    if tracker is None or isinstance(tracker, str):
        return load(tracker or SHIPPED)
    if not callable(tracker):
        kind = type(tracker).__name__
        raise DeviceError(
            f"tracker: a {kind} cannot be called; give a class or a function that makes it, as lambda config: ..."
        )
    _refuse_oracle(tracker, f"tracker {name_of(tracker)}")
    return tracker


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
    file = _file_of_module.get(make_device.__module__)
    return f"{file or make_device.__module__}:{name}"


def short_name(spec: str) -> str:
    """Return the name of a class or function without its module or file, or of the program without its folder."""
    if spec.startswith(PREFIX):
        words = spec.removeprefix(PREFIX).split()
        return Path(words[0]).name if words else PREFIX
    return spec.rpartition(":")[2]


def show_truth(device: Device, frame: WorldFrame, truth: ScanTruth) -> None:
    """Pass the ground truth of the next scan to an oracle; a tracker does not receive it."""
    if hasattr(type(device), "see_truth"):
        device.see_truth(frame, truth)  # type: ignore[attr-defined]


def _load_plugin(name: str) -> DeviceFactory:
    if name not in TRACKERS.names():
        raise DeviceError(f"--tracker {name}: should be {FORMS}, or one of {', '.join(TRACKERS.names())}")
    try:
        with contained():
            factory: DeviceFactory = TRACKERS.load(name)
    except PluginError as error:
        raise DeviceError(f"--tracker {name}: {error}") from error
    _refuse_oracle(factory, f"--tracker {name}")
    return factory


def _load_module(module_name: str, spec: str) -> ModuleType:
    here = _search_last(Path.cwd())
    try:
        with _one_line_errors(spec), contained():
            return importlib.import_module(module_name)
    except DeviceError as error:
        cause = error.__cause__
        missing = cause.name if isinstance(cause, ModuleNotFoundError) else None
        if missing is None or not f"{module_name}.".startswith(f"{missing}."):
            raise  # the module exists, and one of its own imports fails
        new_name = former_names.remedy(cause, module_name) if cause else ""
        message = f"--tracker {spec}: no module {missing} on the Python path or in {here}{new_name}"
        raise DeviceError(message) from cause


def _load_file(path: Path, spec: str) -> ModuleType:
    """Import a file under a name that cannot collide with a package; once per process."""
    if not path.is_file():
        raise DeviceError(f"--tracker {spec}: no file {path}; give the path of a Python file")
    path = path.resolve()
    name = f"tracker_file_{path.stem}_{hashlib.blake2b(str(path).encode(), digest_size=4).hexdigest()}"
    if name in sys.modules:
        return sys.modules[name]
    found = importlib.util.spec_from_file_location(name, path)
    assert found is not None
    assert found.loader is not None
    module = importlib.util.module_from_spec(found)
    _search_last(path.parent)
    sys.modules[name] = module  # before it is executed: dataclasses look their module up
    try:
        with _one_line_errors(spec), contained():
            found.loader.exec_module(module)
    except BaseException:
        del sys.modules[name]
        raise
    _file_of_module[name] = path.relative_to(Path.cwd()) if path.is_relative_to(Path.cwd()) else path
    return module


def _search_last(folder: Path) -> str:
    """Append a folder to the Python path: its modules must not hide installed packages that are imported later."""
    if str(folder) not in sys.path:
        sys.path.append(str(folder))
    return str(folder)


@contextmanager
def _one_line_errors(spec: str) -> Iterator[None]:
    """Turn an error while the user's module is imported into one line that names file and line."""
    try:
        yield
    except (Exception, SystemExit, GeneratorExit) as error:
        reason = " ".join(str(error.msg if isinstance(error, SyntaxError) else error).split())
        where = f"--tracker {spec}: {place_of(error)}{type(error).__name__}"
        raise DeviceError(f"{where}: {reason}{former_names.remedy(error)}") from error


def place_of(error: BaseException, apart_from: tuple[str, ...] = ()) -> str:
    """Return "FILE, line N: " of the user's code that raised an error, empty if no such code was reached.

    `apart_from` are files of the harness.
    """
    if isinstance(error, SyntaxError) and error.filename:
        return f"{error.filename}, line {error.lineno}: "
    libraries = tuple(sysconfig.get_path(name) for name in ("stdlib", "purelib", "platlib"))
    frames = [frame for frame in traceback.extract_tb(error.__traceback__) if not frame.filename.startswith("<")]
    frames = [frame for frame in frames if frame.filename not in (__file__, *apart_from)]
    own = [frame for frame in frames if not frame.filename.startswith(libraries)] or frames
    return f"{own[-1].filename}, line {own[-1].lineno}: " if own else ""
