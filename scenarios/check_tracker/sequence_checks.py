"""Checks over sequences of scans and between instances of a tracker, and their table."""

import time
import traceback
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from itertools import zip_longest
from pathlib import Path
from typing import Any

from luxloop.scenarios.check_tracker.check_drives import CheckDrive
from luxloop.scenarios.document.document import Answer, Document, Section, Span, Table
from luxloop.scenarios.errors import DeviceError
from luxloop.scenarios.run import child_process, user_code
from luxloop.scenarios.run.child_process import ChildError, ChildTimeoutError
from luxloop.scenarios.run.device import Device
from luxloop.scenarios.run.output_checks import (
    Fault,
    Faults,
    check_covariances,
    check_shapes,
    check_trace,
    check_values,
)
from luxloop.scenarios.run.process_tracker import START_FACTOR, STEP_TIMEOUT_S
from luxloop.scenarios.run.trace_hash import TraceHash
from luxloop.tracker.records import Status, StepTrace, Tracks
from luxloop.tracker.scan import Scan
from luxloop.tracker.tracker import TrackerConfig

MakeTracker = Callable[[TrackerConfig], Device]

CHECKS = {
    "accepts a TrackerConfig": "accept one argument, the scenario's [tracker] table, and share no state",
    "accepts every scan": "return the remaining tracks, also for an empty or invalid scan",
    "returns Tracks": "return Tracks or (Tracks, StepTrace), see tracker/records.py",
    "shapes and types": "give each field the shape and type documented in tracker/records.py",
    "values are finite": "omit tracks whose state is unknown",
    "codes are valid": "use ids from 0, Status, the index of a model, and corner signs of +1 and -1",
    "ids are unique": "give each track of a scan its own id",
    "dead ids are not reused": "count ids up, and never assign an id twice",
    "probabilities sum to 1": "normalise model_probability row by row; without models, use Tracks.from_boxes",
    "covariances are valid": "keep them symmetric and positive semidefinite, e.g. by P = (P + P') / 2",
    "trace matches its scan": "label each point of this scan, in its order; see StepTrace",
    "scans are not modified": "copy before modifying: the grader reads the scan after the tracker",
    "outputs are not modified": "return copies: the grader keeps every output until the end of the run",
    "deterministic": "use a seeded random generator per instance, and do not iterate over sets",
    "instances are independent": "keep state in the instance, not in its class or module",
}
"""Remedy by check, in the order of the table."""


@dataclass(frozen=True, slots=True)
class Findings:
    """Results of all checks of one tracker."""

    faults: tuple[Fault, ...]
    done: frozenset[str]
    """Checks that were executed; the others had no data."""

    def of(self, check: str) -> list[Fault]:
        """Return the faults of one check, in the order of detection."""
        return [fault for fault in self.faults if fault.check == check]

    @property
    def passed(self) -> bool:
        """True if there are no faults."""
        return not self.faults


OUTPUT_CHECKS = (
    "returns Tracks", "shapes and types", "values are finite", "codes are valid", "ids are unique",
    "dead ids are not reused", "probabilities sum to 1", "covariances are valid", "scans are not modified",
    "outputs are not modified",
)  # fmt: skip
"""Checks that are executed if there is at least one output."""


def examine(make_device: MakeTracker, drives: list[CheckDrive]) -> Findings:
    """Check a tracker on all drives and return the findings.

    Parameters
    ----------
    make_device
        Makes an instance of the tracker from a `TrackerConfig`.
    drives
        Scans, see `check_drives.drives`. The first drive is repeated with a second instance, and the first and the last
        one with two interleaved instances.
    """
    faults, done = [], {"accepts a TrackerConfig", "accepts every scan"}
    replays = []
    for drive in drives:
        replay = Replay(make_device, drive)
        replay.run()
        replays.append(replay)
        faults += replay.faults
        if replay.hashes:
            done |= {*OUTPUT_CHECKS, *(["trace matches its scan"] if replay.traced else [])}
    if replays[0].hashes and not replays[0].failed:
        faults += _repeat(make_device, drives[0], replays[0])
        faults += _interleave(make_device, drives, replays)
        done |= {"deterministic", "instances are independent"}
    return Findings(tuple(faults), frozenset(done & CHECKS.keys()))


@dataclass
class Replay:
    """A drive processed by one instance of a tracker."""

    make_device: MakeTracker
    drive: CheckDrive
    faults: list[Fault] = field(default_factory=list)
    hashes: list[str] = field(default_factory=list)
    """Hash of each output, computed when it was returned."""
    traced: bool = False
    failed: bool = False
    """True after an error that ends the replay."""

    def __post_init__(self) -> None:
        self._outputs: list[Tracks] = []
        self._dead: set[int] = set()
        self._device: Device | None = None
        self._device = self._call("accepts a TrackerConfig", 0, self.make_device, TrackerConfig())

    def run(self) -> None:
        """Process all scans, then check that no output was modified."""
        for index in range(len(self.drive.scans)):
            self.step(index)
        for index, (tracks, returned) in enumerate(zip(self._outputs, self.hashes, strict=True)):
            if _hash(tracks) != returned:
                self._add_faults([Fault("outputs are not modified", "the output was modified by later steps")], index)
                return

    def step(self, index: int) -> None:
        """Process one scan, unless the replay has failed."""
        if self.failed or self._device is None:
            return
        scan = self.drive.scans[index]
        before = _hash(scan)
        output = self._call("accepts every scan", index, self._device.step, scan)
        if self.failed:
            return
        if _hash(scan) != before:
            self._add_faults([Fault("scans are not modified", "step modified the scan")], index)
        self._check(output, scan, index)

    def _call(self, check: str, index: int, call: Callable[..., Any], *arguments: object) -> Any:
        """Call into the tracker; any exception or exit is a finding and ends the replay."""
        try:
            return call(*arguments)
        except KeyboardInterrupt:
            raise
        except BaseException as error:
            self._add_faults([Fault(check, _message(error))], index)
            self.failed = True

    def _check(self, output: object, scan: Scan, index: int) -> None:
        match output:
            case Tracks() as tracks:
                trace = None
            case (Tracks() as tracks, StepTrace() as trace):
                self.traced = True
            case _:
                self._add_faults([Fault("returns Tracks", f"returned {type(output).__name__}")], index)
                self.failed = True
                return
        shapes = list(check_shapes(tracks))
        self._add_faults(shapes, index)
        if shapes:
            self.failed = True
            return
        self._add_faults([*check_values(tracks), *check_covariances(tracks), *self._check_dead(tracks)], index)
        self._add_faults(check_trace(trace, scan) if trace else [], index)
        self._outputs.append(tracks)
        self.hashes.append(_hash(tracks))

    def _check_dead(self, tracks: Tracks) -> Faults:
        dead = tracks.status == Status.DEAD
        reused = self._dead & set(tracks.id[~dead].tolist())
        if reused:
            yield Fault("dead ids are not reused", f"track {min(reused)} was dead before")
        self._dead |= set(tracks.id[dead].tolist())

    def _add_faults(self, faults: Iterable[Fault], index: int) -> None:
        self.faults += [fault._replace(where=self.drive.where(index)) for fault in faults]


def _repeat(make_device: MakeTracker, drive: CheckDrive, first: Replay) -> Faults:
    """Compare a second instance with the first one."""
    again = Replay(make_device, drive)
    again.run()
    yield from _compare("deterministic", first, again, "a second instance gives different outputs")


def _interleave(make_device: MakeTracker, drives: list[CheckDrive], independent: list[Replay]) -> Faults:
    """Compare two instances that process two drives in turns with independent ones."""
    pair = [Replay(make_device, drive) for drive in (drives[0], drives[-1])]
    for indices in zip_longest(*(range(len(replay.drive.scans)) for replay in pair)):
        for replay, index in zip(pair, indices, strict=True):
            if index is not None:
                replay.step(index)
    what = "the outputs differ while another instance is in use"
    for alone, interleaved in zip((independent[0], independent[-1]), pair, strict=True):
        yield from _compare("instances are independent", alone, interleaved, what)


def _compare(check: str, one: Replay, other: Replay, what: str) -> Faults:
    for index, (a, b) in enumerate(zip_longest(one.hashes, other.hashes)):
        if a != b:
            yield Fault(check, what, one.drive.where(index))
            return


def _hash(record: Scan | Tracks) -> str:
    digest = TraceHash()
    digest.add(record)
    return digest.hexdigest()


def _message(error: BaseException) -> str:
    """Return the error and the line of the tracker that raised it."""
    last = traceback.extract_tb(error.__traceback__)[-1]
    return f"{type(error).__name__}: {' '.join(str(error).split())} ({last.filename}:{last.lineno})"


def checks_document(findings: Findings, name: str) -> Document:
    """Return the checks of a tracker; failed ones show the fault, its location and the remedy."""
    failed = sum(bool(findings.of(check)) for check in CHECKS)
    said = f"{name} fails {failed} of {len(CHECKS)} checks" if failed else f"{name} meets the contract"
    answer = Answer(said, "passed" if findings.passed else "failed", "good" if findings.passed else "bad")
    table = Table("")
    table.add_column("check", no_wrap=True)
    table.add_column("")
    table.add_column("")
    for check, remedy in CHECKS.items():
        faults = findings.of(check)
        if faults:
            first, others = faults[0], f" (and {len(faults) - 1} more times)" if len(faults) > 1 else ""
            message = f"{first.what}; in {first.where}{others}; {remedy}"
            table.add_row(check, Span("failed", "bad", badge=True), message)
        elif check in findings.done:
            table.add_row(check, Span("passed", "good"))
        else:
            table.add_row(check, Span("not done", "warn"), Span("no data to check", "dim"))
    return Document(f"Contract of {name}", answer, [], [Section("checks", "Checks", [table])])


ANSWER_MAX = 1 << 24
"""Longest answer [bytes]."""
ENDED = "accepts every scan"
"""Check that fails if the process does not answer."""


def examine_apart(spec: str, drives: list[CheckDrive]) -> Findings:
    """Check a tracker on all drives.

    Raises
    ------
    DeviceError
        It cannot be imported.
    """
    deadline = time.monotonic() + START_FACTOR * STEP_TIMEOUT_S
    try:
        answer = child_process.ask(__name__, (spec, str(Path.cwd()), drives), ANSWER_MAX, deadline)
        found = Findings(tuple(Fault(*map(str, fault)) for fault in answer["faults"]), frozenset(answer["done"]))
    except ChildTimeoutError:
        return _ended(f"took more than {START_FACTOR * STEP_TIMEOUT_S:g} s")
    except (ChildError, ValueError, KeyError, TypeError) as error:
        return _ended(f"its process {error}")
    if answer["error"]:
        raise DeviceError(f"--tracker {spec}: {answer['error']}")
    return found


def _ended(what: str) -> Findings:
    return Findings((Fault(ENDED, what, "one of the drives"),), frozenset())


def serve() -> None:
    """Answer one request: check a tracker of the user in this process."""
    child_process.answer(_found)


def _found(request: tuple[str, str, list[CheckDrive]]) -> dict[str, object]:
    spec, folder, drives = request
    try:
        found = examine(user_code.load(spec, Path(folder)), drives)
    except user_code.UserCodeError as error:
        return {"error": str(error), "faults": [], "done": []}
    return {"error": "", "faults": list(found.faults), "done": sorted(found.done)}
