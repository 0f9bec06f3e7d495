"""Trackers that break their contract: each ends the run with one line and a code other than 0, and writes nothing."""

import json
import os
import subprocess

import pytest
from support import rogue_trackers, short_run
from support.few import few

from luxloop.scenarios.cli import main
from luxloop.scenarios.run.child_process import SUPERVISOR

BROKEN = {
    "Exits": "raised SystemExit: 0",
    "TyperExit": "raised Exit: 0",
    "Interrupts": "raised KeyboardInterrupt",
    "GeneratorExits": "raised GeneratorExit",
    "BaseError": "raised BaseException: base",
    "Fails": "raised ValueError: a long story",
    "StopsIteration": "raised StopIteration",
    "OutOfMemory": "raised MemoryError",
    "PosesAsSimulator": "raised SimulatorFailedError: the simulator died",
    "PosesAsTraffic": "raised TrafficEndedError: the ego arrived",
    "PosesAsInput": "raised ScenarioError: bad file",
    "EndsProcess": "ended with exit code 0",
    "BecomesAnotherProgram": "ended with exit code 0",
    "EndsProcessInThread": "ended with exit code 0",
    "EndsProcessByPosix": "ended with exit code 0",
    "EndsProcessByLibc": "ended with exit code 0",
    "KillsItself": "ended by signal SIGKILL",
    "KillsTheGroupOfItsParent": "ended by signal SIGKILL",
    "StopsItsParent": "took more than 0.3 s",
    "RemovesFolder": "raised FileNotFoundError",
    "ClosesFiles": "closed its standard input or output",
    "BlocksTheAlarm": "took more than 0.3 s",
    "StopsItself": "took more than 0.3 s",
    "StopsByTrace": "took more than 0.3 s",
    "SegfaultsByRecursion": "ended by signal SIGSEGV",
    "FaultsInAMappedFile": "ended by signal SIGBUS",
    "ReportsItsOwnEnd": "ended with exit code 3",
    "RaisesNameless": "raised Named: error",
    "AnswersTwice": "answered before it was asked",
    "WritesToItsAnswers": "answered 1735357040 bytes of kind 114",
    "ReadsItsRequests": "took more than 0.3 s",
    "HangsAtStart": "warm-up, start: took more than 3 s",
    "Allocates": "raised MemoryError",
    "FillsTheDisk": "raised OSError: [Errno 27] File too large",
    "LeavesGrandchildAndHangs": "took more than 0.3 s",
    "IgnoresInterrupts": "took more than 0.3 s",
    "Recurses": "raised RecursionError",
    "ExitsAtStart": "ExitsAtStart: warm-up, start: ",
    "TakesNoConfig": "takes 1 positional argument but 2 were given",
    "HasNoStep": "object has no attribute 'step'",
    "Sleeps": "took more than 0.3 s",
    "Spins": "took more than 0.3 s",
    "IgnoresOneInterrupt": "took more than 0.3 s",
    "WritesPoints": "raised ValueError: assignment destination is read-only",
    "WritesPose": "read-only",
    "SendsNanPastTheChecks": "mean is not finite",
    "ReturnsNone": "returned NoneType; return Tracks",
    "ReturnsText": "returned str; return Tracks",
    "ReturnsGenerator": "returned generator; return Tracks",
    "ReturnsClass": "returned type; return Tracks",
    "ReturnsPairWithoutTrace": "returned tuple; return Tracks",
    "ReturnsEmptyRecord": "returned a record that cannot be read",
    "HasTheClassOfTracks": "returned a record that cannot be read",
    "BillionsOfTracks": "id: 1099511627776 tracks; at most 10000 can be graded",
    "Awaits": "returned coroutine; return Tracks",
    "NanPosition": "track 2: mean is not finite (position, heading)",
    "InfiniteHeading": "track 2: mean is not finite (position, heading)",
    "HalfAVelocity": "track 1: mean is not finite (velocity",
    "HugePosition": "track 1: mean is beyond 1e+09",
    "NanSize": "track 2: size is not finite",
    "NegativeSize": "track 1: size is not above 0",
    "ZeroSize": "track 1: size is not above 0",
    "InfiniteCovariance": "track 1: covariance is not finite",
    "AsymmetricCovariance": "track 1: covariance is not symmetric",
    "ShortMean": "mean is float64 (2, 6), not floats (2, 8)",
    "OneTrackLess": "size is float64 (1, 2), not floats (2, 2)",
    "ListForArray": "mean is list, not an array (2, 8)",
    "FloatIds": "id is float64 (2,), not integers (2,)",
    "TextIds": "id is <U1 (2,), not integers (2,)",
    "ObjectIds": "id is object (2,), not integers (2,)",
    "BoolIds": "id is bool (2,), not integers (2,)",
    "NegativeIds": "track -1: id is not from 0 to 2^63 - 1",
    "EnormousIds": "track 9223372036854775808: id is not from 0 to 2^63 - 1",
    "TwiceTheSameId": "id 7 occurs 2 times",
    "UnknownStatus": "track 2: status is not a member of Status",
    "UnknownModel": "track 2: model is not an index of models",
    "OddCorner": "track 1: corner_sign",
    "Overconfident": "track 1: model_probability sums to 3.0",
    "OtherModels": "models is ('cv', 'stationary', 'ca'), but was ('stationary', 'cv', 'ca') before",
    "ModelsOfLists": "cannot be read (TypeError",
    "ManyTracks": "id: 20000 tracks; at most 10000 can be graded",
    "BadBoxes": "raised ValueError: center has shape (1, 2); give (2, 2)",
    "OldTrace": "segments.label has shape",
    "HollowTrace": "cannot be read (AttributeError",
    "Forks": "forked the tracker, and the copy returned",
}
"""Part of the line by tracker; the exit code is 4."""
RETURNS = [*BROKEN][[*BROKEN].index("ReturnsNone") : [*BROKEN].index("Forks")]
"""Trackers whose fault is what they return, not what they do to the process."""
QUICK = ("Exits", "EndsProcessByLibc", "KillsTheGroupOfItsParent", "LeavesGrandchildAndHangs", "HollowTrace", "Forks")
"""Those with a process of their own in `make test`, one of each kind; `make slow` runs the others."""

HARMLESS = (
    "LeavesGrandchild",
    "DeletesResults",
    "ForksQuietly",
    "LeavesThread",
    "ChangesFolder",
    "SeesTruth",
    "FactoryOfOneThatSeesTruth",
    "LooksForTheScenario",
    "ForgesByGc",
    "ChangesLibraries",
    "UnlocksScan",
    "ChangesEarlierTracks",
    "Prints",
    "Warns",
    "LeavesDaemon",
    "FakesTheClock",
    "SignalsTheJudge",
    "HangsAtExit",
)
"""Trackers whose misdeed has no effect: their result is that of `Honest`."""


@pytest.fixture
def folder(tmp_path, monkeypatch):
    (tmp_path / "here").mkdir()
    monkeypatch.chdir(tmp_path / "here")
    short_run.write(tmp_path / "here")
    return tmp_path / "here"


def arguments(name):
    """Return the command; only trackers that hang have a short limit, which a slow machine would exceed."""
    place = f"{rogue_trackers.__file__}:{name}"
    hangs = "took more than" in BROKEN.get(name, "")
    limit_s = "0.3" if hangs else "20"
    return [
        "run",
        "short.toml",
        "--tracker",
        place,
        "--no-recording",
        "--json",
        "--out",
        "ran",
        "--step-timeout",
        limit_s,
    ]


def result_of(name, capfd, *options):
    """Return the trace hash and the metrics that are not times."""
    assert main([*arguments(name), *options]) == 0
    document = json.loads(capfd.readouterr().out)
    return document["trace_hash"], {k: v for k, v in document["metrics"].items() if not k.startswith("perf.")}


@pytest.mark.parametrize("name", few(BROKEN, *QUICK))
def test_a_broken_contract_is_one_line_with_exit_code_4(name, folder, capfd):
    assert_refused(name, folder, capfd)


@pytest.mark.parametrize("name", RETURNS)
def test_a_broken_record_is_one_line_from_a_tracker_in_this_process(name, folder, capfd):
    assert_refused(name, folder, capfd, "--in-process")


def assert_refused(name, folder, capfd, *options):
    assert main([*arguments(name), *options]) == 4
    out, err = capfd.readouterr()
    assert out == ""
    assert err.startswith(f"luxloop: error: {rogue_trackers.__file__}:{name}".replace(f"{folder}/", ""))
    assert err.count("\n") == 1
    assert BROKEN[name] in err
    assert name in ("ExitsAtStart", "HangsAtStart", "TakesNoConfig") or " frame " in err
    assert [path.name for path in folder.iterdir()] == ["short.toml"]
    assert processes(name) == []


def test_the_table_has_every_tracker():
    """Each class of the support module is used by a test of this file."""
    elsewhere = {"Honest", "Tracker", "Tracks"}
    classes = {name for name, value in vars(rogue_trackers).items() if isinstance(value, type) and name[0].isupper()}
    imported = {"Path", "ScenarioError", "SimulatorFailedError", "TrafficEndedError", "StepTrace", "Kind"}
    assert classes - imported - elsewhere == BROKEN.keys() | set(HARMLESS) - {"FactoryOfOneThatSeesTruth"}
    assert len(BROKEN) >= 75


def processes(*names):
    """Return the command lines of supervisors that this process started, and of grandchildren of these trackers."""
    odd = {" ".join(rogue_trackers.GRANDCHILDREN[name]) for name in names if name in rogue_trackers.GRANDCHILDREN}
    listing = subprocess.run(["ps", "-eo", "ppid,args"], capture_output=True, text=True, check=True).stdout
    rows = [line.split(None, 1) for line in listing.splitlines()]
    return [args for parent, args in rows if args in odd or (parent == str(os.getpid()) and SUPERVISOR in args)]


@pytest.mark.usefixtures("folder")
@pytest.mark.parametrize("names", [HARMLESS[:3], pytest.param(HARMLESS[3:], marks=pytest.mark.slow)])
def test_misdeeds_without_effect_leave_the_result_as_it_is(names, capfd):
    """JSON stays valid, and the trace and the metrics are bit for bit those of an honest tracker."""
    honest = result_of("Honest", capfd, "--in-process")
    for name in names:
        assert result_of(name, capfd) == honest, name
    assert processes(*names) == []
