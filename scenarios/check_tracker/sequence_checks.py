"""Checks of how a tracker behaves from scan to scan, and from instance to instance."""

import traceback
from collections.abc import Iterable
from dataclasses import dataclass, field
from itertools import zip_longest

from scenarios.check_tracker.check_drives import CheckDrive
from scenarios.check_tracker.checks import CHECKS, Fault, Faults, Findings
from scenarios.check_tracker.output_checks import check_covariances, check_shapes, check_trace, check_values
from scenarios.run.device import Device, DeviceFactory
from scenarios.run.trace_hash import TraceHash
from tracker.records import Status, StepTrace, Tracks
from tracker.scan import Scan
from tracker.tracker import TrackerConfig

OF_ANSWERS = (
    "returns Tracks", "shapes and types", "values are finite", "codes are known", "ids are unique",
    "dead ids stay dead", "probabilities sum to 1", "covariances are sound", "scans are left alone",
    "answers are left alone",
)  # fmt: skip
"""Checks that are done as soon as there is one answer."""


def examine(make_device: DeviceFactory, drives: list[CheckDrive]) -> Findings:
    """Drive a tracker through all drives, the first one several times."""
    faults, done = [], {"is made from a TrackerConfig", "takes every scan"}
    passages = []
    for drive in drives:
        passage = Passage(make_device, drive)
        passage.to_end()
        passages.append(passage)
        faults += passage.faults
        if passage.hashes:
            done |= {*OF_ANSWERS, *(["the trace fits its scan"] if passage.traced else [])}
    if passages[0].hashes and not passages[0].broke:
        faults += _repeat(make_device, drives[0], passages[0])
        faults += _interleave(make_device, drives, passages)
        done |= {"same scans, same answers", "instances are independent"}
    return Findings(tuple(faults), frozenset(done & CHECKS.keys()))


@dataclass
class Passage:
    """One instance on its way through one drive."""

    make_device: DeviceFactory
    drive: CheckDrive
    faults: list[Fault] = field(default_factory=list)
    hashes: list[str] = field(default_factory=list)
    """Of the answers, as they were given."""
    traced: bool = False
    broke: bool = False
    """Whether it could not go on."""

    def __post_init__(self) -> None:
        self._answers: list[Tracks] = []
        self._dead: set[int] = set()
        self._device: Device | None = None
        try:
            self._device = self.make_device(TrackerConfig())
        except Exception as error:  # whatever a stranger's tracker raises is what is looked for
            self._note([Fault("is made from a TrackerConfig", _told(error))], 0)
            self.broke = True

    def to_end(self) -> None:
        """Take all scans, and look at all answers again at the end."""
        for index in range(len(self.drive.scans)):
            self.step(index)
        for index, (tracks, given) in enumerate(zip(self._answers, self.hashes, strict=True)):
            if _hash(tracks) != given:
                self._note([Fault("answers are left alone", "the answer to it was changed by later steps")], index)
                return

    def step(self, index: int) -> None:
        """Take one scan, unless the instance broke before."""
        if self.broke or self._device is None:
            return
        scan = self.drive.scans[index]
        before = _hash(scan)
        try:
            answer = self._device.step(scan)
        except Exception as error:
            self._note([Fault("takes every scan", _told(error))], index)
            self.broke = True
            return
        if _hash(scan) != before:
            self._note([Fault("scans are left alone", "step changed the scan")], index)
        self._look_at(answer, scan, index)

    def _look_at(self, answer: object, scan: Scan, index: int) -> None:
        match answer:
            case Tracks() as tracks:
                trace = None
            case (Tracks() as tracks, StepTrace() as trace):
                self.traced = True
            case _:
                self._note([Fault("returns Tracks", f"returned {type(answer).__name__}")], index)
                self.broke = True
                return
        shapes = list(check_shapes(tracks))
        self._note(shapes, index)
        if shapes:
            self.broke = True
            return
        self._note([*check_values(tracks), *check_covariances(tracks), *self._check_dead(tracks)], index)
        self._note(check_trace(trace, scan) if trace else [], index)
        self._answers.append(tracks)
        self.hashes.append(_hash(tracks))

    def _check_dead(self, tracks: Tracks) -> Faults:
        dead = tracks.status == Status.DEAD
        back = self._dead & set(tracks.id[~dead].tolist())
        if back:
            yield Fault("dead ids stay dead", f"track {min(back)} was dead before, and lives")
        self._dead |= set(tracks.id[dead].tolist())

    def _note(self, faults: Iterable[Fault], index: int) -> None:
        self.faults += [fault._replace(where=self.drive.where(index)) for fault in faults]


def _repeat(make_device: DeviceFactory, drive: CheckDrive, first: Passage) -> Faults:
    """A second instance, all the same."""
    again = Passage(make_device, drive)
    again.to_end()
    yield from _compare("same scans, same answers", first, again, "a second instance answers otherwise")


def _interleave(make_device: DeviceFactory, drives: list[CheckDrive], alone: list[Passage]) -> Faults:
    """Two instances take turns in two drives."""
    pair = [Passage(make_device, drive) for drive in (drives[0], drives[-1])]
    for indices in zip_longest(*(range(len(passage.drive.scans)) for passage in pair)):
        for passage, index in zip(pair, indices, strict=True):
            if index is not None:
                passage.step(index)
    what = "it answers otherwise while another instance is at work"
    for before, beside in zip((alone[0], alone[-1]), pair, strict=True):
        yield from _compare("instances are independent", before, beside, what)


def _compare(check: str, one: Passage, other: Passage, what: str) -> Faults:
    for index, (a, b) in enumerate(zip_longest(one.hashes, other.hashes)):
        if a != b:
            yield Fault(check, what, one.drive.where(index))
            return


def _hash(record: Scan | Tracks) -> str:
    digest = TraceHash()
    digest.add(record)
    return digest.hexdigest()


def _told(error: Exception) -> str:
    """The error, and the line of the tracker that raised it."""
    last = traceback.extract_tb(error.__traceback__)[-1]
    return f"{type(error).__name__}: {' '.join(str(error).split())} ({last.filename}:{last.lineno})"
