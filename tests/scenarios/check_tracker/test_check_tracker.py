"""Contract checker: trackers with one planted fault each, and trackers without faults."""

import inspect
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from support.few import few
from support.paths import EXAMPLES
from support.scripts import load_script

from luxloop.scenarios.check_tracker import sequence_checks
from luxloop.scenarios.check_tracker.check_drives import NullTracker, drives
from luxloop.scenarios.check_tracker.sequence_checks import CHECKS
from luxloop.scenarios.cli import main
from luxloop.scenarios.run.output_checks import OPTIONAL, SHAPES
from luxloop.tracker.records import MODELS, Status, Tracks
from luxloop.tracker.tracker import Tracker

my_tracker = load_script(EXAMPLES / "my_tracker.py")
PatchTracker = my_tracker.PatchTracker


@pytest.fixture(scope="module")
def all_drives():
    return drives()


@pytest.fixture(scope="module")
def two(all_drives):
    """The first scans of the simulated drive, and the unusual scans."""
    return [cut(all_drives[0], 12), cut(all_drives[-1], None)]


def cut(drive, count):
    return drive._replace(scans=drive.scans[:count], labels=drive.labels[:count])


class WithModels(PatchTracker):
    """Reports one model with certainty, and the front left corner."""

    def step(self, scan):
        tracks = super().step(scan)
        count, mean = len(tracks), tracks.mean.copy()
        mean[:, [2, 3, 4, 5, 7]] = 0.0
        return replace(
            tracks,
            mean=mean,
            covariance=np.tile(np.eye(8), (count, 1, 1)),
            model_probability=np.tile(np.eye(len(MODELS))[0], (count, 1)),
            model=np.zeros(count, int),
            model_position_odom=np.repeat(mean[:, None, :2], len(MODELS), axis=1),
            corner_sign=np.ones((count, 2), int),
        )


def changed(**fields):
    """Return a tracker with some output fields replaced by functions of the tracks."""

    class Changed(WithModels):
        def step(self, scan):
            tracks = super().step(scan)
            return replace(tracks, **{name: make(tracks) for name, make in fields.items()}) if len(tracks) else tracks

    return Changed


class Raises(PatchTracker):
    def step(self, scan):
        if not len(scan):
            raise IndexError("index -1 is out of bounds")
        return super().step(scan)


class Exits(PatchTracker):
    def step(self, scan):
        if not len(scan):
            sys.exit(0)
        return super().step(scan)


class ReturnsNone(PatchTracker):
    def step(self, scan):
        super().step(scan)


class NoConfig(PatchTracker):
    def __init__(self):
        super().__init__(None)


class ReusesDeadIds(PatchTracker):
    """Reports all its ids as dead in one scan, and reuses them later."""

    def step(self, scan):
        tracks = super().step(scan)
        self.count = getattr(self, "count", 0) + 1
        status = np.full(len(tracks), Status.DEAD if self.count == 3 else Status.CONFIRMED, np.uint8)
        return replace(tracks, status=status)


class ModifiesScan(PatchTracker):
    """Shifts the points of the scan in place."""

    def step(self, scan):
        scan.points_ego[:] += 1.0
        return super().step(scan)


class ReusesBuffer(PatchTracker):
    """Returns an array that it overwrites in the next step."""

    buffer = None

    def step(self, scan):
        tracks = super().step(scan)
        if self.buffer is None:
            self.buffer = np.zeros((100, 8))
        self.buffer[: len(tracks)] = tracks.mean
        return replace(tracks, mean=self.buffer[: len(tracks)])


class Unseeded(PatchTracker):
    def step(self, scan):
        tracks = super().step(scan)
        return replace(tracks, size=tracks.size + 1e-9 * np.random.default_rng().random(tracks.size.shape))


class SharesState(PatchTracker):
    """Counts ids in a class attribute, which each new instance resets."""

    born_by_all = 0

    def __init__(self, config):
        super().__init__(config)
        SharesState.born_by_all = 0

    def ids_of(self, centers):
        self.born = SharesState.born_by_all
        found = super().ids_of(centers)
        SharesState.born_by_all = self.born
        return found


class DuplicatesIds(PatchTracker):
    """Associates each observation with the nearest track, even if taken: wrong only if an object is split in two."""

    def ids_of(self, centers):
        return np.concatenate([super(DuplicatesIds, self).ids_of(center[None]) for center in centers] or [self.ids[:0]])


class WrongTrace(Tracker):
    """Returns the trace of the previous scan."""

    before = None

    def step(self, scan):
        tracks, trace = super().step(scan)
        self.before, returned = trace, self.before or trace
        return tracks, returned


def negative(tracks):
    covariance = tracks.covariance.copy()
    covariance[:, 0, 0] = -1.0
    return covariance


def asymmetric(tracks):
    covariance = tracks.covariance.copy()
    covariance[:, 0, 1] = 0.1
    return covariance


@pytest.mark.parametrize(
    ("tracker", "check", "what"),
    [
        (NoConfig, "accepts a TrackerConfig", "takes 1 positional argument but 2 were given"),
        (Raises, "accepts every scan", "IndexError: index -1 is out of bounds ("),
        (Exits, "accepts every scan", "SystemExit: 0 ("),
        (ReturnsNone, "returns Tracks", "returned NoneType"),
        (changed(mean=lambda t: t.mean[:, :6]), "shapes and types", "not floats ("),
        (changed(size=lambda t: t.size.tolist()), "shapes and types", "size is list, not an array ("),
        (changed(id=lambda t: t.id.astype(float)), "shapes and types", "id is float64 ("),
        (changed(models=lambda _: ("cv", "cv", "ca")), "shapes and types", "models is ('cv', 'cv', 'ca'), not a tuple"),
        (changed(models=lambda _: ("cv", "glide", "ca")), "shapes and types", "not a tuple of names in MODEL_NAMES"),
        (changed(models=lambda _: ("cv", "ca")), "shapes and types", "not floats ("),
        (
            changed(prediction_odom=lambda t: np.zeros((len(t), 3, 3, 2))),
            "shapes and types",
            "prediction_odom is float64 (",
        ),
        (changed(mean=lambda t: t.mean * np.nan), "values are finite", "mean is not finite"),
        (changed(size=lambda t: t.size * 0.0), "values are finite", "size is not above 0"),
        (changed(status=lambda t: t.status + np.uint8(7)), "codes are valid", "status is not a member of Status"),
        (changed(corner_sign=lambda t: 2 * t.corner_sign), "codes are valid", "corner_sign"),
        (changed(model=lambda t: t.model + 3), "codes are valid", "model is not an index of models"),
        (changed(id=lambda t: 0 * t.id), "ids are unique", "id 0 occurs"),
        (DuplicatesIds, "ids are unique", "occurs 2 times"),
        (ReusesDeadIds, "dead ids are not reused", "was dead before"),
        (changed(model_probability=lambda t: t.model_probability * 0.9), "probabilities sum to 1", "sums to 0.9"),
        (changed(covariance=negative), "covariances are valid", "has a negative eigenvalue -1.0"),
        (changed(covariance=asymmetric), "covariances are valid", "is not symmetric"),
        (changed(covariance=lambda t: t.covariance * np.inf), "covariances are valid", "is not finite"),
        (WrongTrace, "trace matches its scan", "segments.label has shape"),
        (ModifiesScan, "scans are not modified", "step modified the scan"),
        (ReusesBuffer, "outputs are not modified", "was modified by later steps"),
        (Unseeded, "deterministic", "a second instance gives different outputs"),
        (SharesState, "instances are independent", "while another instance is in use"),
    ],
    ids=lambda value: value if value in CHECKS else "",
)
@pytest.mark.filterwarnings("ignore:invalid value encountered:RuntimeWarning")
def test_each_planted_fault_is_found_by_its_check(tracker, check, what, two):
    findings = sequence_checks.examine(tracker, two)
    assert not findings.passed
    assert any(what in fault.what for fault in findings.of(check)), findings.faults[:3]
    if check not in ("deterministic", "scans are not modified"):  # these fail other checks as well
        assert {fault.check for fault in findings.faults} == {check}


def test_every_check_has_a_tracker_that_fails_it():
    (mark,) = [m for m in test_each_planted_fault_is_found_by_its_check.pytestmark if m.name == "parametrize"]
    assert {check for _, check, _ in mark.args[1]} == CHECKS.keys()


def test_every_field_of_the_record_is_checked():
    optional = {name for name, p in inspect.signature(Tracks).parameters.items() if p.default is None}
    assert {*SHAPES, "models"} == inspect.signature(Tracks).parameters.keys()
    assert set(OPTIONAL) == optional


@pytest.mark.parametrize("tracker", few([Tracker, PatchTracker, WithModels, NullTracker], Tracker))
def test_trackers_that_meet_the_contract_pass(tracker, all_drives):
    findings = sequence_checks.examine(tracker, all_drives)
    assert findings.faults == ()
    assert findings.done == CHECKS.keys() - (set() if tracker is Tracker else {"trace matches its scan"})


def test_a_fault_names_drive_scan_and_label(two):
    (first, *_) = sequence_checks.examine(Raises, two).of("accepts every scan")
    assert first.where == "unusual scans, scan 0 at 0.00 s, no points"


def test_the_drives_contain_vehicles_gaps_and_unusual_scans(all_drives):
    """Without vehicles the checks would have no data."""
    tracker = Tracker()
    counts = [len(tracker.step(scan)[0]) for scan in all_drives[0].scans]
    assert max(counts) >= 2
    assert {drive.name for drive in all_drives} == {
        "simulated drive", "simulated drive with a gap of 10 s", "simulated drive with 0.4 s without returns",
        "simulated drive with Unix time", "unusual scans",
    }  # fmt: skip
    for drive in all_drives:
        times = [scan.time for scan in drive.scans]
        assert (np.diff(times) > 0).all()
    assert min(len(scan) for scan in all_drives[-1].scans) == 0


# --- the command line

GOOD = (EXAMPLES / "my_tracker.py").read_text(encoding="utf-8")
BAD = GOOD.replace("[2], CAR_M)", "[2], -CAR_M)")


@pytest.mark.parametrize(
    ("module", "text", "code", "message"),
    [
        ("sound_tracker", GOOD, 0, "PASSED: sound_tracker:PatchTracker meets the contract"),
        pytest.param(
            "odd_tracker", BAD, 1, "FAILED: odd_tracker:PatchTracker fails 1 of 15 checks", marks=pytest.mark.slow
        ),
    ],
)
def test_the_command_prints_a_table_and_exits_by_the_result(module, text, code, message, tmp_path, monkeypatch, capfd):
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(tmp_path)
    Path(f"{module}.py").write_text(text)
    assert main(["check-tracker", f"{module}:PatchTracker"]) == code
    out, err = capfd.readouterr()
    assert message in out
    assert err == ""
    assert ("omit tracks whose state is unknown" in " ".join(out.split())) == bool(code)


def test_a_missing_tracker_is_a_one_line_error(capfd):
    assert main(["check-tracker", "nowhere:Tracker"]) == 2
    assert capfd.readouterr().err.startswith("luxloop: error: --tracker nowhere:Tracker: no module nowhere")
