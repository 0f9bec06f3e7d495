"""Traffic in a process of its own: the same frames, the same errors, and no process that is left over."""

import os
import pickle
import signal
import subprocess
import sys
import tempfile
import threading
import time
from contextlib import closing
from dataclasses import fields, replace
from pathlib import Path

import numpy as np
import pytest
from support.paths import TESTS
from support.toy_traffic import ToyTraffic

from scenarios.files import shipped
from scenarios.files.scenario import Scenario
from sim.physical.physical_config import PhysicalConfig
from sim.process.process_source import AHEAD, ProcessSource, _Process
from sim.source import EgoCommand, SimulatorFailedError, TrafficEndedError, TrafficInputError
from sim.sumo.sumo_source import SumoSource
from sim.world import Obstacles, WorldFrame

FRAMES = 10
LEVELS = pytest.mark.parametrize("ahead", [0, 1, AHEAD])


def arrays(record):
    """All values of a record as arrays, in order."""
    parts = [record, record.ego, record.actors] if isinstance(record, WorldFrame) else [record]
    values = [getattr(part, field.name) for part in parts for field in fields(part)]
    return [np.asarray(value) for value in values if not hasattr(value, "__dataclass_fields__")]


def assert_same(one, other):
    pairs = list(zip(arrays(one), arrays(other), strict=True))
    assert pairs
    assert all(a.dtype == b.dtype and a.tobytes() == b.tobytes() for a, b in pairs)


def play(source, seed, frames=FRAMES, commands=()):
    """Obstacles and frames of a run; `commands` by the frame they come before."""
    records: list[Obstacles | WorldFrame] = [source.reset(seed)]
    for index in range(frames):
        if index in commands:
            source.apply(commands[index])
        records.append(source.step())
    return records


def step(source, frames):
    for _ in range(frames):
        source.step()


def assert_plays_the_same(apart, source, *arguments):
    for one, other in zip(play(apart, *arguments), play(source, *arguments), strict=True):
        assert_same(one, other)
    np.testing.assert_array_equal(apart.origin, source.origin)


def lines(path):
    return Path(path).read_text().splitlines() if Path(path).exists() else []


def until(condition, patience_s=10.0):
    end = time.monotonic() + patience_s
    while not condition():
        assert time.monotonic() < end, "it never came to that"
        time.sleep(0.01)


def is_gone(pid):
    """Whether a process has ended; one that nobody has waited for yet has."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] == "Z"
    except FileNotFoundError:
        return True


def processes(report):
    return [int(line.split()[1]) for line in lines(report) if line.startswith("process")]


@LEVELS
def test_frames_obstacles_and_origin_are_the_same_bit_for_bit(ahead):
    with closing(ProcessSource(ToyTraffic(), "toy", ahead)) as apart:
        for seed in (1, 2, 1):
            assert_plays_the_same(apart, ToyTraffic(), seed)


def test_a_command_between_two_frames_acts_as_in_the_same_process():
    """Were the next frame computed already, it would show the speed before the command."""
    commands = {index: EgoCommand(speed_mps=float(index)) for index in (0, 1, 4, 5, 9)}
    with closing(ProcessSource(ToyTraffic(), "toy", ahead=0)) as apart:
        assert_plays_the_same(apart, ToyTraffic(), 1, FRAMES, commands)


def test_a_command_to_traffic_that_runs_ahead_is_refused():
    with closing(ProcessSource(ToyTraffic(), "toy")) as apart:
        apart.reset(1)
        with pytest.raises(TrafficInputError, match="not set up for a controlled ego"):
            apart.apply(EgoCommand(speed_mps=1.0))


def test_a_refused_command_is_told_and_the_run_can_go_on():
    with closing(ProcessSource(ToyTraffic(), "toy", ahead=0)) as apart:
        apart.reset(1)
        with pytest.raises(TrafficInputError, match="toy: give a speed"):
            apart.apply(EgoCommand(lane=1))
        apart.apply(EgoCommand(speed_mps=3.0))
        assert apart.step().ego.velocity_world[0] == 3.0


@LEVELS
@pytest.mark.parametrize(
    ("fate", "error", "message"),
    [
        ("ended", TrafficEndedError, "^the ego arrived at 0.80 s$"),
        ("failed", SimulatorFailedError, "^toy at 0.80 s: no more$"),
        ("bug", RuntimeError, "^ZeroDivisionError in the traffic's own process: one over nothing"),
        ("exit", SimulatorFailedError, r"died \(exit code 7\) at 0\.80 s; it last said: Error: too many cars; try"),
        ("crash", SimulatorFailedError, r"^toy's process died \(signal 11\) at 0\.80 s; try the same input"),
        ("killed", SimulatorFailedError, r"^toy's process died \(signal 9\) at 0\.80 s; somebody killed it, or memory"),
    ],
)
def test_an_error_arrives_as_itself_after_all_frames_before_it(fate, error, message, ahead, capfd):
    with closing(ProcessSource(ToyTraffic(fate), "toy", ahead)) as apart:
        apart.reset(1)
        for index in range(FRAMES):
            assert apart.step().index == index
        with pytest.raises(error, match=message):
            apart.step()
    assert capfd.readouterr() == ("", ""), "what the process prints stays with it"


def test_an_error_that_is_ours_to_mend_tells_where_it_came_from():
    with closing(ProcessSource(ToyTraffic("bug"), "toy")) as apart, pytest.raises(RuntimeError) as error:
        play(apart, 1, FRAMES + 1)
    assert "toy_traffic.py" in error.value.__notes__[0]


def test_what_failed_is_not_stepped_again(tmp_path):
    """A simulator that is stepped after it gave up may do anything; the frames ahead of the loop would do so."""
    with closing(ProcessSource(ToyTraffic("failed", report=str(tmp_path / "report")), "toy")) as apart:
        for _ in range(2):
            with pytest.raises(SimulatorFailedError, match="no more"):
                play(apart, 1, FRAMES + 1)
            with pytest.raises(SimulatorFailedError, match="no more"):
                apart.step()
    assert lines(tmp_path / "report").count(f"step {FRAMES}") == 2


@pytest.mark.parametrize(
    ("fate", "error", "message"),
    [
        ("no start", TrafficInputError, "^toy: seed 3 is not there; choose another$"),
        ("died at start", SimulatorFailedError, r"^toy's process died \(signal 11\) at its start; try"),
    ],
)
def test_a_start_that_fails_is_told(fate, error, message):
    with closing(ProcessSource(ToyTraffic(fate), "toy")) as apart:
        with pytest.raises(error, match=message):
            apart.reset(3)
        with pytest.raises(SimulatorFailedError, match="toy is not running: reset comes before all else"):
            apart.step()


def test_a_process_that_is_killed_while_the_loop_waits_for_it_is_an_error_at_once(tmp_path):
    report = tmp_path / "report"
    with closing(ProcessSource(ToyTraffic("stuck", report=str(report)), "toy")) as apart:
        apart.reset(1)
        threading.Timer(0.2, lambda: os.kill(processes(report)[0], signal.SIGKILL)).start()
        begin = time.monotonic()
        with pytest.raises(SimulatorFailedError, match="signal 9"):
            step(apart, FRAMES + 1)
    assert time.monotonic() - begin < 5.0


def test_only_so_many_frames_are_computed_ahead(tmp_path):
    report = tmp_path / "report"
    with closing(ProcessSource(ToyTraffic(last=-1, report=str(report)), "toy", ahead=3)) as apart:
        apart.reset(1)
        apart.step()
        until(lambda: "step 3" in lines(report))
        time.sleep(0.1)
        assert [line for line in lines(report) if "step" in line] == [f"step {index}" for index in range(4)]


def test_a_run_is_closed_amid_frames_that_nobody_reads(tmp_path):
    """Two frames of 30000 actors are more than a pipe holds: the process waits for a reader when it is told to stop."""
    report = tmp_path / "report"
    with closing(ProcessSource(ToyTraffic(count=30_000, last=-1, report=str(report)), "toy", ahead=50)) as apart:
        apart.reset(1)
        until(lambda: "step 0" in lines(report))
    assert lines(report)[-1] == "closed"
    assert len(lines(report)) < 10, "it went on to compute what nobody wants"


def test_a_process_serves_run_after_run_in_the_folder_of_each(tmp_path, monkeypatch):
    """Starting one takes a second, of which a sweep has thousands."""
    for folder in (tmp_path / "a", tmp_path / "b"):
        folder.mkdir()
        monkeypatch.chdir(folder)
        with (
            closing(ProcessSource(ToyTraffic("ended", report="report"), "toy")) as apart,
            pytest.raises(TrafficEndedError),
        ):
            play(apart, 1, FRAMES + 1)
    assert processes(tmp_path / "a" / "report") == processes(tmp_path / "b" / "report")


@pytest.mark.parametrize("fate", ["failed", "bug"])
def test_a_process_whose_run_failed_serves_no_other(fate, tmp_path):
    report = tmp_path / "report"
    for _ in range(2):
        apart = ProcessSource(ToyTraffic(fate, report=str(report)), "toy")
        with closing(apart), pytest.raises((SimulatorFailedError, RuntimeError)):
            play(apart, 1, FRAMES + 1)
    first, second = processes(report)
    assert first != second
    assert is_gone(first)


@pytest.mark.parametrize("fate", ["failed", "crash", "stuck"])
def test_what_a_simulator_left_goes_with_its_process(fate, tmp_path, monkeypatch):
    """However that ends: after an error, by itself, or ended amid a frame by whoever waited for it."""
    (tmp_path / "temporary").mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path / "temporary"))
    monkeypatch.setattr(_Process, "idle", [])  # a new one, which finds this folder
    report = tmp_path / "report"
    with closing(ProcessSource(ToyTraffic(fate, report=str(report), litter=True), "toy", ahead=0)) as apart:
        play(apart, 1)
        assert [path.name for path in (tmp_path / "temporary").rglob("*.litter")] != []
        if fate == "stuck":
            interrupt_when(lambda: f"step {FRAMES}" in lines(report))
        with pytest.raises((SimulatorFailedError, KeyboardInterrupt)):
            apart.step()
    assert list((tmp_path / "temporary").iterdir()) == []


def interrupt_when(condition):
    """Press Ctrl-C once it has come to that."""

    def wait():
        until(condition)
        os.kill(os.getpid(), signal.SIGINT)

    threading.Thread(target=wait).start()


def test_two_runs_at_once_are_two_processes(tmp_path):
    report = str(tmp_path / "report")
    one, two = (ProcessSource(ToyTraffic(report=report), "toy") for _ in range(2))
    with closing(one), closing(two):
        one.reset(1)
        two.reset(1)
        for _ in range(FRAMES):
            assert_same(one.step(), two.step())
    assert len(set(processes(report))) == 2


def test_a_process_that_died_between_two_runs_is_replaced(tmp_path):
    report = tmp_path / "report"
    with closing(ProcessSource(ToyTraffic(report=str(report)), "toy")) as apart:
        play(apart, 1)
        apart.close()
        os.kill(processes(report)[0], signal.SIGKILL)
        until(lambda: is_gone(processes(report)[0]))
        assert_plays_the_same(apart, ToyTraffic(), 1)


def program(text, **options):
    """Start a program of a few lines that can import what this one can."""
    text = "from support.toy_traffic import ToyTraffic\nfrom sim.process.process_source import ApartSource\n" + text
    paths = os.pathsep.join([str(TESTS), *sys.path])
    return subprocess.Popen([sys.executable, "-c", text], env={**os.environ, "PYTHONPATH": paths}, **options)


@pytest.mark.parametrize("state", ["", "apart.step()", "apart.close()"], ids=["started", "running", "idle"])
def test_a_process_whose_parent_is_killed_ends_by_itself(state, tmp_path):
    report = tmp_path / "report"
    parent = program(
        f"""
import os, signal
apart = ApartSource(ToyTraffic(count=5000, last=-1, report={str(report)!r}), "toy")
apart.reset(1)
{state}
os.kill(os.getpid(), signal.SIGKILL)
"""
    )
    assert parent.wait() == -signal.SIGKILL
    (child,) = processes(report)
    until(lambda: is_gone(child))


def test_an_idle_process_ends_with_its_parent_and_without_a_word(tmp_path):
    report = tmp_path / "report"
    parent = program(
        f"""
apart = ApartSource(ToyTraffic(report={str(report)!r}), "toy")
apart.reset(1)
apart.close()
""",
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
    )
    assert parent.communicate() == (b"", None)
    until(lambda: is_gone(processes(report)[0]))


def test_ctrl_c_reaches_both_and_only_the_parent_answers(tmp_path):
    """The process is amid a run; it must be there to be closed, and not print a traceback of its own."""
    report = tmp_path / "report"
    parent = program(
        f"""
apart = ApartSource(ToyTraffic(last=-1, report={str(report)!r}), "toy")
apart.reset(1)
try:
    while True:
        apart.step()
except KeyboardInterrupt:
    apart.close()
""",
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        start_new_session=True,
    )
    until(lambda: len(lines(report)) > 20)
    os.killpg(parent.pid, signal.SIGINT)
    assert parent.communicate() == (b"", None)
    assert parent.returncode == 0
    until(lambda: is_gone(processes(report)[0]))


def test_a_fork_does_not_share_its_parents_process(tmp_path):
    """Two readers of one pipe would each get half of the frames."""
    report = tmp_path / "report"
    parent = program(
        f"""
import os
apart = ApartSource(ToyTraffic(report={str(report)!r}), "toy")
apart.reset(1)
apart.close()
fork = os.fork()
apart.reset(2)
apart.close()
if fork:
    os.waitpid(fork, 0)
"""
    )
    assert parent.wait() == 0
    first, *later = processes(report)
    assert later.count(first) == 1
    assert len(set(later)) == 2


def test_a_frame_travels_fast():
    """A hundred road users in well under 0.2 ms; the limit here is for a busy machine."""
    source = ToyTraffic(count=100)
    source.reset(1)
    frame = source.step()
    best = min(seconds(lambda: pickle.loads(pickle.dumps(frame, protocol=5))) for _ in range(50))
    assert best < 0.2e-3


def seconds(call):
    begin = time.perf_counter()
    call()
    return time.perf_counter() - begin


@pytest.fixture(scope="module")
def crossing():
    """Makes sources of the crossing's traffic, with settings that differ."""
    scenario = Scenario.load(shipped.find("sumo-crossing"))
    return lambda **settings: SumoSource(replace(scenario.traffic, **settings), scenario.folder, 60.0)


@pytest.mark.parametrize("ahead", [0, AHEAD])
def test_sumo_apart_is_sumo(crossing, ahead):
    source = crossing()
    with closing(source), closing(ProcessSource(source, "SUMO", ahead)) as apart:
        assert_plays_the_same(apart, source, 5, 60)


def test_the_process_loads_no_more_than_sumo_needs(tmp_path):
    """It would start later for each library more. The program that asks for the traffic has loaded all of them."""
    told = program(
        f"""
import pathlib, numba, scipy, pandas, scenarios.files.scenario as file
from scenarios import listing
from sim.sumo.sumo_source import SumoSource
from support.toy_traffic import Inventory
crossing = file.Scenario.load(listing.find("sumo-crossing"))
apart = ApartSource(Inventory(SumoSource(crossing.traffic, crossing.folder, 60.0)), "SUMO")
apart.reset(1)
try:
    apart.step()
except Exception as end:
    pathlib.Path({str(tmp_path / "told")!r}).write_text(str(end))
apart.close()
"""
    )
    assert told.wait() == 0
    loaded = set((tmp_path / "told").read_text().split())
    assert {"numpy", "libsumo", "sim.sumo.sumo_source"} <= loaded
    heavy = {"rerun", "pandas", "pydantic", "shapely", "highway_env", "scenarios", "tracker"}
    assert loaded.isdisjoint(heavy)


def test_sumo_with_a_commanded_ego_apart_is_sumo(crossing):
    source = crossing(ego_control=True, physical=PhysicalConfig(lookahead_s=0.0))
    commands = {index: EgoCommand(speed_mps=speed) for index, speed in {5: 2.0, 20: 9.0, 21: 0.0, 40: 12.0}.items()}
    with closing(source), closing(ProcessSource(source, "SUMO", ahead=0)) as apart:
        assert_plays_the_same(apart, source, 5, 60, commands)
        commanded, free = play(source, 5, 60, commands), play(source, 5, 60)
    assert arrays(commanded[-1])[0] == arrays(free[-1])[0]
    assert not np.array_equal(commanded[-1].ego.pose_world, free[-1].ego.pose_world), "the commands did nothing"
