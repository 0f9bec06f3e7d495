"""The contract checker: trackers with one planted fault each, and two that have none."""

import importlib.util
import inspect
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from support.paths import EXAMPLES

from scenarios.check_tracker import sequence_checks
from scenarios.check_tracker.check_drives import Silent, drives
from scenarios.check_tracker.checks import CHECKS
from scenarios.check_tracker.output_checks import MAY_BE_NONE, SHAPES
from scenarios.cli import main
from tracker.records import Status, Tracks
from tracker.tracker import Tracker

_spec = importlib.util.spec_from_file_location("my_tracker", EXAMPLES / "my_tracker.py")
my_tracker = importlib.util.module_from_spec(_spec)
_spec.loader.exec_module(my_tracker)
PatchTracker = my_tracker.PatchTracker


@pytest.fixture(scope="module")
def all_drives():
    return drives()


@pytest.fixture(scope="module")
def two(all_drives):
    """The real drive and the odd scans, fewer of them."""
    return [cut(all_drives[0], 12), cut(all_drives[-1], None)]


def cut(drive, count):
    return drive._replace(scans=drive.scans[:count], labels=drive.labels[:count])


def changed(**fields):
    """A tracker whose answers have some fields replaced: by values, or by functions of the tracks."""

    class Changed(PatchTracker):
        def step(self, scan):
            tracks = super().step(scan)
            return replace(tracks, **{name: make(tracks) for name, make in fields.items()}) if len(tracks) else tracks

    return Changed


class Raises(PatchTracker):
    def step(self, scan):
        if not len(scan):
            raise IndexError("index -1 is out of bounds")
        return super().step(scan)


class Nothing(PatchTracker):
    def step(self, scan):
        super().step(scan)


class Unmade(PatchTracker):
    def __init__(self):
        super().__init__(None)


class Revives(PatchTracker):
    """Reports all ids that it has ever given as dead, and later gives them again."""

    def step(self, scan):
        tracks = super().step(scan)
        self.count = getattr(self, "count", 0) + 1
        status = np.full(len(tracks), Status.DEAD if self.count == 3 else Status.CONFIRMED, np.uint8)
        return replace(tracks, status=status)


class Scribbles(PatchTracker):
    """Shifts the points of the scan in place, as a careless transform does."""

    def step(self, scan):
        scan.points_ego[:] += 1.0
        return super().step(scan)


class Buffers(PatchTracker):
    """Answers with an array that it writes into again."""

    buffer = None

    def step(self, scan):
        tracks = super().step(scan)
        if self.buffer is None:
            self.buffer = np.zeros((100, 8))
        self.buffer[: len(tracks)] = tracks.mean
        return replace(tracks, mean=self.buffer[: len(tracks)])


class Draws(PatchTracker):
    def step(self, scan):
        tracks = super().step(scan)
        return replace(tracks, size=tracks.size + 1e-9 * np.random.default_rng().random(tracks.size.shape))


class Shares(PatchTracker):
    """Counts ids in its class; with a new count for each instance that starts alone."""

    born_by_all = 0

    def __init__(self, config):
        super().__init__(config)
        Shares.born_by_all = 0

    def ids_of(self, centers):
        self.born = Shares.born_by_all
        found = super().ids_of(centers)
        Shares.born_by_all = self.born
        return found


class GivesTwice(PatchTracker):
    """Takes the nearest for each, whoever has taken it before: wrong only where one thing falls into two."""

    def ids_of(self, centers):
        return np.concatenate([super(GivesTwice, self).ids_of(center[None]) for center in centers] or [self.ids[:0]])


class WrongTrace(Tracker):
    """Its trace is of the scan before."""

    before = None

    def step(self, scan):
        tracks, trace = super().step(scan)
        self.before, given = trace, self.before or trace
        return tracks, given


def negative(tracks):
    covariance = tracks.covariance.copy()
    covariance[:, 0, 0] = -1.0
    return covariance


def skewed(tracks):
    covariance = tracks.covariance.copy()
    covariance[:, 0, 1] = 0.1
    return covariance


@pytest.mark.parametrize(
    ("tracker", "check", "what"),
    [
        (Unmade, "is made from a TrackerConfig", "takes 1 positional argument but 2 were given"),
        (Raises, "takes every scan", "IndexError: index -1 is out of bounds ("),
        (Nothing, "returns Tracks", "returned NoneType"),
        (changed(mean=lambda t: t.mean[:, :6]), "shapes and types", "not floats ("),
        (changed(size=lambda t: t.size.tolist()), "shapes and types", "size is list, not an array ("),
        (changed(id=lambda t: t.id.astype(float)), "shapes and types", "id is float64 ("),
        (changed(mean=lambda t: t.mean * np.nan), "values are finite", "mean is not finite"),
        (changed(size=lambda t: t.size * 0.0), "values are finite", "size is not above 0"),
        (changed(status=lambda t: t.status + np.uint8(7)), "codes are known", "status is none of Status"),
        (changed(corner_sign=lambda t: 0 * t.corner_sign), "codes are known", "corner_sign"),
        (changed(model=lambda t: t.model + 3), "codes are known", "model is none of MODELS"),
        (changed(id=lambda t: 0 * t.id), "ids are unique", "id 0 is there"),
        (GivesTwice, "ids are unique", "is there 2 times"),
        (Revives, "dead ids stay dead", "was dead before, and lives"),
        (changed(model_probability=lambda t: t.model_probability * 0.9), "probabilities sum to 1", "sums to 0.9"),
        (changed(covariance=negative), "covariances are sound", "has a negative eigenvalue -1.0"),
        (changed(covariance=skewed), "covariances are sound", "is not symmetric"),
        (changed(covariance=lambda t: t.covariance * np.inf), "covariances are sound", "is not finite"),
        (WrongTrace, "the trace fits its scan", "segments.label has shape"),
        (Scribbles, "scans are left alone", "step changed the scan"),
        (Buffers, "answers are left alone", "was changed by later steps"),
        (Draws, "same scans, same answers", "a second instance answers otherwise"),
        (Shares, "instances are independent", "while another instance is at work"),
    ],
    ids=lambda value: value if value in CHECKS else "",
)
@pytest.mark.filterwarnings("ignore:invalid value encountered:RuntimeWarning")
def test_each_planted_fault_is_found_by_its_check_first(tracker, check, what, two):
    findings = sequence_checks.examine(tracker, two)
    assert not findings.passed
    assert any(what in fault.what for fault in findings.of(check)), findings.faults[:3]
    if check not in ("same scans, same answers", "scans are left alone"):  # these show in other checks, too
        assert {fault.check for fault in findings.faults} == {check}


def test_every_check_has_a_tracker_that_fails_it():
    (mark,) = [m for m in test_each_planted_fault_is_found_by_its_check_first.pytestmark if m.name == "parametrize"]
    assert {check for _, check, _ in mark.args[1]} == CHECKS.keys()


def test_every_field_of_the_record_is_checked():
    optional = {name for name, p in inspect.signature(Tracks).parameters.items() if p.default is None}
    assert SHAPES.keys() == inspect.signature(Tracks).parameters.keys()
    assert set(MAY_BE_NONE) == optional


@pytest.mark.parametrize("tracker", [Tracker, PatchTracker, Silent])
def test_trackers_that_keep_the_contract_pass(tracker, all_drives):
    findings = sequence_checks.examine(tracker, all_drives)
    assert findings.faults == ()
    assert findings.done == CHECKS.keys() - (set() if tracker is Tracker else {"the trace fits its scan"})


def test_a_fault_is_told_with_drive_scan_and_what_is_odd_about_it(two):
    (first, *_) = sequence_checks.examine(Raises, two).of("takes every scan")
    assert first.where == "odd scans, scan 0 at 0.00 s, no points"


def test_the_drives_see_vehicles_occlusions_and_what_no_rig_delivers(all_drives):
    """Without vehicles in them the checks would check nothing."""
    tracker = Tracker()
    counts = [len(tracker.step(scan)[0]) for scan in all_drives[0].scans]
    assert max(counts) >= 2
    assert {drive.name for drive in all_drives} == {
        "real drive", "real drive with a gap of 10 s", "real drive with half a second of no returns",
        "clock of seconds since 1970", "odd scans",
    }  # fmt: skip
    for drive in all_drives:
        times = [scan.time for scan in drive.scans]
        assert (np.diff(times) > 0).all()
    assert min(len(scan) for scan in all_drives[-1].scans) == 0


# --- the command line

GOOD = (EXAMPLES / "my_tracker.py").read_text(encoding="utf-8")
BAD = GOOD.replace("np.eye(len(MODELS))[0]", "np.ones(len(MODELS))")


@pytest.mark.parametrize(
    ("module", "text", "code", "words"),
    [
        ("sound_tracker", GOOD, 0, "PASSED: sound_tracker:PatchTracker keeps the contract"),
        ("odd_tracker", BAD, 1, "FAILED: odd_tracker:PatchTracker fails 1 of 15 checks"),
    ],
)
def test_the_command_prints_a_table_and_exits_by_it(module, text, code, words, tmp_path, monkeypatch, capfd):
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(tmp_path)
    Path(f"{module}.py").write_text(text)
    assert main(["check-tracker", f"{module}:PatchTracker"]) == code
    out, err = capfd.readouterr()
    assert words in out
    assert err == ""
    assert ("normalise model_probability row by row" in " ".join(out.split())) == bool(code)


def test_a_tracker_that_is_not_there_is_one_line(capfd):
    assert main(["check-tracker", "nowhere:Tracker"]) == 2
    assert capfd.readouterr().err.startswith("luxloop: error: --tracker nowhere:Tracker: no module nowhere")
