"""Trackers that break the contract of a tracker in one way each. They behave until their fourth step."""

import asyncio
import atexit
import ctypes
import fcntl
import gc
import mmap
import os
import posix
import shutil
import signal
import subprocess
import sys
import threading
import time
import warnings
from contextlib import suppress
from dataclasses import replace
from pathlib import Path

import numpy as np
import typer

from luxloop.scenarios.errors import ScenarioError
from luxloop.scenarios.run import output_checks
from luxloop.scenarios.run.record_messages import ANSWER, Kind, encode
from luxloop.sim.source import SimulatorFailedError, TrafficEndedError
from luxloop.tracker.records import MODELS, StepTrace, Tracks
from luxloop.tracker.tracker import Tracker

GOOD_STEPS = 4
"""More than the steps of a warm-up, so that the fault appears in the run itself."""


class Honest:
    """Reports one car at a fixed place."""

    def __init__(self, config):
        del config
        self.steps = 0
        self.kept = []

    def step(self, scan):
        self.steps += 1
        return self.odd(scan) if self.steps > GOOD_STEPS else self.fine()

    def odd(self, _):
        return self.fine()

    def fine(self):
        return Tracks.from_boxes([1, 2], [[9.0, 3.0], [-12.0, -4.0]], [0.0, 0.5], (4.5, 1.8), velocity=[5.0, 0.0])


def rogue(odd):
    """Return a tracker class whose later steps are `odd(tracker, scan)`."""
    return type(odd.__name__, (Honest,), {"odd": odd})


def changed(**fields):
    """Return a tracker class that replaces fields of the record, by values or by functions of the tracks."""

    def odd(self, _):
        tracks = self.fine()
        return replace(tracks, **{k: v(tracks) if callable(v) else v for k, v in fields.items()})

    return rogue(odd)


def raising(error):
    """Return a tracker class that raises an exception."""

    def odd(_self, _scan):
        raise error

    return rogue(odd)


def at(array, row, column, value):
    """Return a copy of an array with one element replaced."""
    array = array.copy()
    array[row, column] = value
    return array


# --- the end of the process
Exits = raising(SystemExit(0))
TyperExit = raising(typer.Exit(0))
Interrupts = raising(KeyboardInterrupt())
GeneratorExits = raising(GeneratorExit())
BaseError = raising(BaseException("base"))
Fails = raising(ValueError("a\nlong\nstory"))
StopsIteration = raising(StopIteration())
OutOfMemory = raising(MemoryError())
PosesAsSimulator = raising(SimulatorFailedError("the simulator died"))
PosesAsTraffic = raising(TrafficEndedError("the ego arrived"))
PosesAsInput = raising(ScenarioError("bad file"))


@rogue
def RaisesNameless(_self, _scan):
    nameless = type("Nameless", (type,), {"__name__": property(lambda _cls: 1 / 0)})
    raise nameless("Named", (Exception,), {})("error")


@rogue
def EndsProcess(_self, _scan):
    os._exit(0)


@rogue
def BecomesAnotherProgram(_self, _scan):
    os.execv("/bin/true", ["true"])


@rogue
def EndsProcessByPosix(_self, _scan):
    posix._exit(0)


@rogue
def EndsProcessByLibc(_self, _scan):
    ctypes.CDLL(None).exit(0)


@rogue
def KillsItself(_self, _scan):
    os.kill(os.getpid(), signal.SIGKILL)


@rogue
def KillsTheGroupOfItsParent(_self, _scan):
    os.killpg(os.getpgid(os.getppid()), signal.SIGKILL)
    time.sleep(1e6)


@rogue
def StopsItsParent(_self, _scan):
    os.kill(os.getppid(), signal.SIGSTOP)
    time.sleep(1e6)


@rogue
def ClosesFiles(_self, _scan):
    os.closerange(0, 1000)
    time.sleep(1e6)


@rogue
def BlocksTheAlarm(_self, _scan):
    signal.pthread_sigmask(signal.SIG_BLOCK, set(signal.Signals) - {signal.SIGKILL, signal.SIGSTOP})
    time.sleep(1e6)


@rogue
def StopsItself(_self, _scan):
    os.kill(os.getpid(), signal.SIGSTOP)


@rogue
def StopsByTrace(_self, _scan):
    ctypes.CDLL(None).ptrace(0, 0, 0, 0)
    os.kill(os.getpid(), signal.SIGUSR1)


@rogue
def SegfaultsByRecursion(_self, _scan):
    sys.setrecursionlimit(1 << 30)
    deep = type("Deep", (), {"__repr__": lambda self: repr(self)})
    repr(deep())


@rogue
def FaultsInAMappedFile(_self, _scan):
    with Path("mapped").open("w+b") as file:
        file.truncate(1 << 16)
        mapped = mmap.mmap(file.fileno(), 1 << 16)
        file.truncate(0)
    return mapped[0]


@rogue
def ReportsItsOwnEnd(_self, _scan):
    supervisor = Path(f"/proc/{os.getppid()}/fd")
    for file in supervisor.iterdir():
        with suppress(OSError):  # a socket cannot be opened
            file.write_bytes(b"0\n")
    os._exit(3)


@rogue
def Allocates(self, _scan):
    while True:
        self.kept.append(np.empty(1 << 30))


@rogue
def FillsTheDisk(_self, _scan):
    with Path("large").open("wb") as file:
        file.truncate(1 << 40)


GRANDCHILDREN = {"LeavesGrandchild": ["sleep", "1000.375"], "LeavesGrandchildAndHangs": ["sleep", "1000.625"]}
"""Odd programs by the tracker that leaves them: another process may test the other tracker at the same time."""


@rogue
def LeavesGrandchild(self, _scan):
    subprocess.Popen(GRANDCHILDREN["LeavesGrandchild"], start_new_session=True)
    return self.fine()


@rogue
def LeavesGrandchildAndHangs(_self, _scan):
    subprocess.Popen(GRANDCHILDREN["LeavesGrandchildAndHangs"], start_new_session=True)
    time.sleep(1e6)


@rogue
def LooksForTheScenario(self, _scan):
    """Raises if its folder, command line or environment, or those of its parent, name the scenario or a test."""
    seen = [str(Path.cwd()), *os.environ.values()]
    seen += [Path(f"/proc/{process}/cmdline").read_text() for process in ("self", os.getppid())]
    if any("short" in text or "pytest" in text for text in seen) or list(Path.cwd().iterdir()):
        raise ValueError(f"found {seen}")
    return self.fine()


@rogue
def ForgesByGc(self, _scan):
    """Looks for the truth and the grader among all objects of its process."""
    names = {type(item).__name__ for item in gc.get_objects()}
    if names & {"WorldFrame", "ScanTruth", "Grader", "Scenario"}:
        raise ValueError("found the truth")
    return self.fine()


@rogue
def ChangesLibraries(self, _scan):
    np.linalg.norm = np.hypot = lambda *_, **__: 0.0
    sys.setrecursionlimit(60)
    signal.alarm(1)
    return self.fine()


@rogue
def EndsProcessInThread(self, _scan):
    thread = threading.Thread(target=os._exit, args=(0,))
    thread.start()
    thread.join()
    return self.fine()


@rogue
def Recurses(self, scan):
    return self.odd(scan)


class HangsAtStart(Honest):
    def __init__(self, _config):
        time.sleep(1e6)


class ExitsAtStart(Honest):
    def __init__(self, _config):
        sys.exit(0)


class TakesNoConfig(Honest):
    def __init__(self):
        pass


class HasNoStep:
    def __init__(self, config):
        pass


# --- the connection to the judge
def pipes(mode):
    """Return the ends of pipes of this process for reading or writing, beside 0 to 2."""
    fds = [int(file.name) for file in Path("/proc/self/fd").iterdir() if file.is_fifo()]
    return [fd for fd in fds if fd > 2 and fcntl.fcntl(fd, fcntl.F_GETFL) & os.O_ACCMODE == mode]


@rogue
def AnswersTwice(self, _scan):
    body = encode(self.fine(), None)
    for fd in pipes(os.O_WRONLY):
        os.write(fd, ANSWER.pack(len(body), Kind.OUTPUT) + body)
    return self.fine()


@rogue
def WritesToItsAnswers(self, _scan):
    for fd in pipes(os.O_WRONLY):
        os.write(fd, b"progress\n")
    return self.fine()


@rogue
def ReadsItsRequests(_self, _scan):
    for fd in pipes(os.O_RDONLY):
        os.read(fd, 1)


@rogue
def SendsNanPastTheChecks(self, _scan):
    output_checks.OutputCheck.checked = lambda _self, output, _scan: (output, None)
    return replace(self.fine(), mean=np.full((2, 8), np.nan))


# --- time
@rogue
def Sleeps(_self, _scan):
    time.sleep(1e6)


@rogue
def Spins(_self, _scan):
    while True:
        pass


@rogue
def IgnoresInterrupts(_self, _scan):
    while True:
        with suppress(BaseException):
            time.sleep(1e6)


@rogue
def IgnoresOneInterrupt(self, _scan):
    try:
        time.sleep(1e6)
    except BaseException:
        return self.fine()


# --- the scan
@rogue
def WritesPoints(self, scan):
    scan.points_ego[:] = 0.0
    return self.fine()


@rogue
def WritesPose(self, scan):
    scan.ego_pose_odom[0] += 1.0
    return self.fine()


# --- the record
HasTheClassOfTracks = rogue(lambda *_: type("Other", (), {"__class__": Tracks})())
BillionsOfTracks = changed(id=lambda _: np.broadcast_to(np.int64(1), 1 << 40))
ReturnsNone = rogue(lambda *_: None)
ReturnsText = rogue(lambda *_: "tracks")
ReturnsGenerator = rogue(lambda self, _scan: (self.fine() for _ in range(1)))
ReturnsClass = rogue(lambda *_: Tracks)
ReturnsPairWithoutTrace = rogue(lambda self, _scan: (self.fine(), {}))
ReturnsEmptyRecord = rogue(lambda *_: object.__new__(Tracks))
NanPosition = changed(mean=lambda t: at(t.mean, 1, 0, np.nan))
InfiniteHeading = changed(mean=lambda t: at(t.mean, 1, 6, np.inf))
HalfAVelocity = changed(mean=lambda t: at(t.mean, 0, 3, np.nan))
HugePosition = changed(mean=lambda t: at(t.mean, 0, 0, 1e300))
NanSize = changed(size=lambda t: at(t.size, 1, 1, np.nan))
NegativeSize = changed(size=lambda t: -t.size)
ZeroSize = changed(size=lambda t: 0.0 * t.size)
InfiniteCovariance = changed(covariance=lambda _: np.full((2, 8, 8), np.inf))
AsymmetricCovariance = changed(covariance=lambda _: np.triu(np.ones((2, 8, 8))))
ShortMean = changed(mean=lambda t: t.mean[:, :6])
OneTrackLess = changed(size=lambda t: t.size[:1])
ListForArray = changed(mean=lambda t: t.mean.tolist())
FloatIds = changed(id=np.array([1.0, 2.0]))
TextIds = changed(id=np.array(["a", "b"]))
ObjectIds = changed(id=np.array([1, None], dtype=object))
BoolIds = changed(id=np.array([True, False]))
NegativeIds = changed(id=np.array([-1, 2]))
EnormousIds = changed(id=np.array([1, 2**63], dtype=np.uint64))
TwiceTheSameId = changed(id=np.array([7, 7]))
UnknownStatus = changed(status=np.array([1, 9], dtype=np.uint8))
UnknownModel = changed(model=np.array([0, 3]))
OddCorner = changed(corner_sign=np.array([[1, 0], [1, 1]]))
Overconfident = changed(model_probability=np.ones((2, len(MODELS))))
OtherModels = changed(models=("cv", "stationary", "ca"))
ModelsOfLists = changed(models=([], [], []))
ManyTracks = rogue(lambda *_: Tracks.from_boxes(np.arange(20_000), np.zeros((20_000, 2)), 0.0, (4.0, 2.0)))
BadBoxes = rogue(lambda *_: Tracks.from_boxes([1, 2], [[0.0, 0.0]], 0.0, (4.0, 2.0)))


class Awaits(Honest):
    def __init__(self, config):
        super().__init__(config)
        warnings.simplefilter("ignore")  # Python's warning would be a second line

    async def step(self, _scan):
        await asyncio.sleep(0)


class OldTrace(Tracker):
    """Returns the trace of the first scan."""

    first = None

    def step(self, scan):
        tracks, trace = super().step(scan)
        self.first = self.first or trace
        return tracks, self.first


class HollowTrace(Tracker):
    def step(self, scan):
        tracks, trace = super().step(scan)
        return tracks, StepTrace(trace.segments, trace.linkage, trace.candidates, None, trace.track_id)


# --- the process around
class SeesTruth(Honest):
    def see_truth(self, frame, truth):
        pass


def FactoryOfOneThatSeesTruth(config):
    return SeesTruth(config)


@rogue
def Forks(self, _scan):
    if os.fork() == 0:
        return self.fine()
    time.sleep(0.2)
    return self.fine()


@rogue
def LeavesThread(self, _scan):
    threading.Thread(target=time.sleep, args=(20.0,), name="lasting").start()
    return self.fine()


@rogue
def ChangesFolder(self, _scan):
    os.chdir("/")
    return self.fine()


@rogue
def RemovesFolder(self, _scan):
    shutil.rmtree(Path.cwd())
    return self.fine()


@rogue
def DeletesResults(self, _scan):
    for folder in Path.cwd().glob(".ran*.partial"):
        shutil.rmtree(folder)
    return self.fine()


# --- no effect on the run
@rogue
def UnlocksScan(self, scan):
    scan.points_ego.setflags(write=True)
    scan.points_ego[:] = 0.0
    object.__setattr__(scan, "time", -1.0)
    return self.fine()


@rogue
def ChangesEarlierTracks(self, _scan):
    for tracks in self.kept:
        tracks.mean[:] = np.nan
        tracks.id[:] = 0
    self.kept.append(self.fine())
    return self.kept[-1]


@rogue
def Prints(self, _scan):
    if not sys.stdout.closed:  # by its step before
        print("progress", flush=True)
    os.write(1, b"progress of compiled code\n")
    os.system("echo progress of another program")
    sys.stdout.close()
    return self.fine()


@rogue
def Warns(self, _scan):
    warnings.simplefilter("error")
    np.seterr(all="raise")
    return self.fine()


@rogue
def ForksQuietly(self, _scan):
    child = os.fork()
    if child == 0:
        os._exit(0)
    os.waitpid(child, 0)
    return self.fine()


@rogue
def FakesTheClock(self, _scan):
    time.monotonic = time.perf_counter = time.time = lambda: 0.0
    return self.fine()


@rogue
def SignalsTheJudge(self, _scan):
    judge = int(Path(f"/proc/{os.getppid()}/stat").read_text().rpartition(")")[2].split()[1])
    for number in (signal.SIGPIPE, signal.SIGCHLD, signal.SIGWINCH, signal.SIGCONT):
        os.kill(judge, number)
    return self.fine()


class HangsAtExit(Honest):
    def __init__(self, config):
        super().__init__(config)
        atexit.register(time.sleep, 1e6)


@rogue
def LeavesDaemon(self, _scan):
    threading.Thread(target=time.sleep, args=(3.0,), daemon=True).start()
    return self.fine()


for _name, _value in list(globals().items()):
    if isinstance(_value, type) and issubclass(_value, Honest):
        _value.__qualname__ = _name  # that of the line
