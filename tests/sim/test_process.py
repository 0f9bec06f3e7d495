"""Traffic in a worker process: identical frames, identical errors, and no orphaned process."""

import errno
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
from support.few import few
from support.paths import TESTS
from support.toy_traffic import ToyTraffic

from luxloop.scenarios.files import shipped
from luxloop.scenarios.files.scenario import Scenario
from luxloop.sim.physical.physical_config import PhysicalConfig
from luxloop.sim.process import process_source
from luxloop.sim.process.process_source import AHEAD, ProcessSource, _Process, start_early
from luxloop.sim.process.worker import Preload, _throttled
from luxloop.sim.source import EgoCommand, SimulatorFailedError, StartStatus, TrafficEndedError, TrafficInputError
from luxloop.sim.sumo.sumo_source import SumoSource
from luxloop.sim.world import Obstacles, WorldFrame

FRAMES = 10
LEVELS = pytest.mark.parametrize("ahead", [0, 1, AHEAD])
FEW_LEVELS = pytest.mark.parametrize("ahead", few([0, 1, AHEAD], AHEAD))


def arrays(record):
    """Return all values of a record as arrays, in order."""
    parts = [record, record.ego, record.actors] if isinstance(record, WorldFrame) else [record]
    values = [getattr(part, field.name) for part in parts for field in fields(part)]
    return [np.asarray(value) for value in values if not hasattr(value, "__dataclass_fields__")]


def assert_same(one, other):
    pairs = list(zip(arrays(one), arrays(other), strict=True))
    assert pairs
    assert all(a.dtype == b.dtype and a.tobytes() == b.tobytes() for a, b in pairs)


def play(source, seed, frames=FRAMES, commands=()):
    """Return obstacles and frames of a run; `commands` by the index of the next frame."""
    records: list[Obstacles | WorldFrame] = [source.reset(seed)]
    for index in range(frames):
        if index in commands:
            source.apply(commands[index])
        records.append(source.step())
    return records


def step(source, frames):
    for _ in range(frames):
        source.step()


def assert_same_run(remote, source, *arguments):
    for one, other in zip(play(remote, *arguments), play(source, *arguments), strict=True):
        assert_same(one, other)
    np.testing.assert_array_equal(remote.origin, source.origin)


def lines(path):
    return Path(path).read_text().splitlines() if Path(path).exists() else []


def until(condition, patience_s=60.0):
    end = time.monotonic() + patience_s
    while not condition():
        assert time.monotonic() < end, "timeout"
        time.sleep(0.01)


def is_gone(pid):
    """Return True if a process has ended, including zombies."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] == "Z"
    except FileNotFoundError:
        return True


def processes(report):
    return [int(line.split()[1]) for line in lines(report) if line.startswith("process")]


@LEVELS
def test_frames_obstacles_and_origin_are_bit_identical(ahead):
    with closing(ProcessSource(ToyTraffic(), "toy", ahead)) as remote:
        for seed in (1, 2, 1):
            assert_same_run(remote, ToyTraffic(), seed)


def test_a_command_between_two_frames_acts_as_in_process():
    """Fails if frames are computed ahead: the next one would have the speed before the command."""
    commands = {index: EgoCommand(speed_mps=float(index)) for index in (0, 1, 4, 5, 9)}
    with closing(ProcessSource(ToyTraffic(), "toy", ahead=0)) as remote:
        assert_same_run(remote, ToyTraffic(), 1, FRAMES, commands)


def test_commands_are_rejected_if_frames_are_computed_ahead():
    with closing(ProcessSource(ToyTraffic(), "toy")) as remote:
        remote.reset(1)
        with pytest.raises(TrafficInputError, match="not set up for a controlled ego"):
            remote.apply(EgoCommand(speed_mps=1.0))


def test_a_rejected_command_raises_and_the_run_continues():
    with closing(ProcessSource(ToyTraffic(), "toy", ahead=0)) as remote:
        remote.reset(1)
        with pytest.raises(TrafficInputError, match="toy: give a speed"):
            remote.apply(EgoCommand(lane=1))
        remote.apply(EgoCommand(speed_mps=3.0))
        assert remote.step().ego.velocity_world[0] == 3.0


@FEW_LEVELS
def test_a_stopped_simulator_is_ended_after_a_time_limit(ahead, tmp_path):
    """A stopped process keeps its pipe open: without a limit, the run would wait for ever."""
    report = tmp_path / "report"
    with closing(ProcessSource(ToyTraffic(last=-1, report=str(report)), "toy", ahead, patience_s=5.0)) as remote:
        remote.reset(1)
        (pid,) = processes(report)
        os.kill(pid, signal.SIGSTOP)
        with pytest.raises(
            SimulatorFailedError, match=r"^toy's process gave no reply for 5 s at 0\.\d\d s and was ended"
        ):
            step(remote, FRAMES)
        until(lambda: is_gone(pid))


def test_a_process_that_was_stopped_between_two_runs_is_replaced(tmp_path, monkeypatch):
    monkeypatch.setattr(process_source, "IDLE_PATIENCE_S", 0.5)
    report = tmp_path / "report"
    with closing(ProcessSource(ToyTraffic(report=str(report)), "toy")) as remote:
        remote.reset(1)
        remote.close()
        (pid,) = processes(report)
        os.kill(pid, signal.SIGSTOP)
        assert_same_run(remote, ToyTraffic(), 2)
        until(lambda: is_gone(pid))


@FEW_LEVELS
@pytest.mark.parametrize(
    ("failure", "error", "message"),
    [
        ("ended", TrafficEndedError, "^the ego arrived at 0.80 s$"),
        ("failed", SimulatorFailedError, "^toy at 0.80 s: no more$"),
        ("bug", RuntimeError, "^ZeroDivisionError in the traffic process: one over nothing"),
        ("exit", SimulatorFailedError, r"died \(exit code 7\) at 0\.80 s; its last message: Error: too many cars; try"),
        ("crash", SimulatorFailedError, r"^toy's process died \(signal 11\) at 0\.80 s; try the same input"),
        (
            "killed",
            SimulatorFailedError,
            r"^toy's process died \(signal 9\) at 0\.80 s; it was killed, possibly out of memory",
        ),
    ],
)
def test_an_error_is_raised_unchanged_after_all_frames_before_it(failure, error, message, ahead, capfd):
    with closing(ProcessSource(ToyTraffic(failure), "toy", ahead)) as remote:
        remote.reset(1)
        for index in range(FRAMES):
            assert remote.step().index == index
        with pytest.raises(error, match=message):
            remote.step()
    assert capfd.readouterr() == ("", ""), "output of the process must not reach the terminal"


@pytest.mark.parametrize("earlier", [True, False], ids=["by an earlier run", "by this run"])
def test_a_crash_is_reported_by_its_signal_in_a_process_that_has_imported_pygame(earlier):
    process_source._terminate_idle()
    with closing(ProcessSource(ToyTraffic(imports="pygame" if earlier else ""), "toy")) as remote:
        play(remote, 1)
    crash = ProcessSource(ToyTraffic("crash", imports="" if earlier else "pygame"), "toy")
    with closing(crash), pytest.raises(SimulatorFailedError, match=r"^toy's process died \(signal 11\) at 0\.80 s;"):
        play(crash, 1, FRAMES + 1)


def test_an_error_of_the_system_keeps_number_and_file():
    """The command line makes one line of it; a bug has a traceback."""
    with closing(ProcessSource(ToyTraffic("refused"), "toy")) as remote, pytest.raises(PermissionError) as error:
        play(remote, 1, FRAMES + 1)
    assert (error.value.errno, error.value.filename) == (errno.EACCES, "cars.csv")


def test_a_bug_keeps_the_traceback_of_the_worker():
    with closing(ProcessSource(ToyTraffic("bug"), "toy")) as remote, pytest.raises(RuntimeError) as error:
        play(remote, 1, FRAMES + 1)
    assert "toy_traffic.py" in error.value.__notes__[0]


def test_a_failed_source_is_not_stepped_again(tmp_path):
    """The behaviour of a simulator after a failure is undefined; computing frames ahead must stop there."""
    with closing(ProcessSource(ToyTraffic("failed", report=str(tmp_path / "report")), "toy")) as remote:
        for _ in range(2):
            with pytest.raises(SimulatorFailedError, match="no more"):
                play(remote, 1, FRAMES + 1)
            with pytest.raises(SimulatorFailedError, match="no more"):
                remote.step()
    assert lines(tmp_path / "report").count(f"step {FRAMES}") == 2


@pytest.mark.parametrize(
    ("failure", "error", "message"),
    [
        ("no start", TrafficInputError, "^toy: seed 3 is not there; choose another$"),
        ("died at start", SimulatorFailedError, r"^toy's process died \(signal 11\) at its start; try"),
    ],
)
def test_a_failed_start_raises(failure, error, message):
    with closing(ProcessSource(ToyTraffic(failure), "toy")) as remote:
        with pytest.raises(error, match=message):
            remote.reset(3)
        with pytest.raises(SimulatorFailedError, match="toy is not running: call reset first"):
            remote.step()


def test_killing_the_process_during_a_step_raises(tmp_path):
    report = tmp_path / "report"
    with closing(ProcessSource(ToyTraffic("stuck", report=str(report)), "toy")) as remote:
        remote.reset(1)
        threading.Timer(0.2, lambda: os.kill(processes(report)[0], signal.SIGKILL)).start()
        with pytest.raises(SimulatorFailedError, match="signal 9"):
            step(remote, FRAMES + 1)
    assert is_gone(processes(report)[0])


def test_the_number_of_frames_computed_ahead_is_limited(tmp_path):
    report = tmp_path / "report"
    with closing(ProcessSource(ToyTraffic(last=-1, report=str(report)), "toy", ahead=3)) as remote:
        remote.reset(1)
        remote.step()
        until(lambda: "step 3" in lines(report))
        time.sleep(0.1)
        assert [line for line in lines(report) if "step" in line] == [f"step {index}" for index in range(4)]


def test_closing_discards_unread_frames(tmp_path):
    """Two frames of 30000 actors exceed the pipe buffer: the process is blocked in a write when the run is closed."""
    report = tmp_path / "report"
    with closing(ProcessSource(ToyTraffic(count=30_000, last=-1, report=str(report)), "toy", ahead=50)) as remote:
        remote.reset(1)
        until(lambda: "step 0" in lines(report))
    assert lines(report)[-1] == "closed"
    assert len(lines(report)) < 10, "it continued to compute frames"


def test_a_process_is_reused_and_changes_to_the_folder_of_each_run(tmp_path, monkeypatch):
    """Starting a process takes a second, and a sweep has thousands of runs."""
    for folder in (tmp_path / "a", tmp_path / "b"):
        folder.mkdir()
        monkeypatch.chdir(folder)
        with (
            closing(ProcessSource(ToyTraffic("ended", report="report"), "toy")) as remote,
            pytest.raises(TrafficEndedError),
        ):
            play(remote, 1, FRAMES + 1)
    assert processes(tmp_path / "a" / "report") == processes(tmp_path / "b" / "report")


@pytest.mark.parametrize("failure", few(["failed", "bug"], "failed"))
def test_a_process_is_not_reused_after_a_failed_run(failure, tmp_path):
    report = tmp_path / "report"
    for _ in range(2):
        remote = ProcessSource(ToyTraffic(failure, report=str(report)), "toy")
        with closing(remote), pytest.raises((SimulatorFailedError, RuntimeError)):
            play(remote, 1, FRAMES + 1)
    first, second = processes(report)
    assert first != second
    assert is_gone(first)


@pytest.mark.parametrize("failure", few(["failed", "crash", "stuck"], "crash"))
def test_temporary_files_are_removed_with_the_process(failure, tmp_path, monkeypatch):
    """After an error, a crash, or termination during a frame."""
    (tmp_path / "temporary").mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path / "temporary"))
    monkeypatch.setattr(_Process, "idle", [])  # start a new process, which uses this folder
    report = tmp_path / "report"
    with closing(ProcessSource(ToyTraffic(failure, report=str(report), litter=True), "toy", ahead=0)) as remote:
        play(remote, 1)
        assert [path.name for path in (tmp_path / "temporary").rglob("*.litter")] != []
        if failure == "stuck":
            interrupt_when(lambda: f"step {FRAMES}" in lines(report))
        with pytest.raises((SimulatorFailedError, KeyboardInterrupt)):
            remote.step()
    assert list((tmp_path / "temporary").iterdir()) == []


def interrupt_when(condition):
    """Send SIGINT when the condition holds."""

    def wait():
        until(condition)
        os.kill(os.getpid(), signal.SIGINT)

    threading.Thread(target=wait).start()


def test_temporary_files_are_removed_before_a_process_is_killed(monkeypatch):
    """Otherwise, a parent that is killed right after it would leave them."""
    process, left = _Process(), []
    until(lambda: Path(process._scratch).exists())
    kill = process._popen.kill
    monkeypatch.setattr(process._popen, "kill", lambda: (left.append(Path(process._scratch).exists()), kill()))
    process.terminate()
    assert left == [False]


def test_progress_is_reported_now_and_then_and_a_new_activity_at_once():
    sent: list[StartStatus] = []
    report = _throttled(sent.append)
    for share in np.linspace(0.0, 1.0, 1000):
        report(StartStatus("loads", share))
    report(StartStatus("runs"))
    assert [sent[0].activity, sent[-1].activity] == ["loads", "runs"]
    assert len(sent) < 100


def test_concurrent_runs_use_separate_processes(tmp_path):
    report = str(tmp_path / "report")
    one, two = (ProcessSource(ToyTraffic(report=report), "toy") for _ in range(2))
    with closing(one), closing(two):
        one.reset(1)
        two.reset(1)
        for _ in range(FRAMES):
            assert_same(one.step(), two.step())
    assert len(set(processes(report))) == 2


def test_an_idle_process_that_died_is_replaced(tmp_path):
    report = tmp_path / "report"
    with closing(ProcessSource(ToyTraffic(report=str(report)), "toy")) as remote:
        play(remote, 1)
        remote.close()
        os.kill(processes(report)[0], signal.SIGKILL)
        until(lambda: is_gone(processes(report)[0]))
        assert_same_run(remote, ToyTraffic(), 1)


@pytest.mark.parametrize("module", ["support.preloaded_traffic", "no_such_module"])
def test_a_process_started_early_imports_a_module_and_serves_the_next_run(module, tmp_path, monkeypatch):
    report, imported = str(tmp_path / "report"), tmp_path / "imported"
    monkeypatch.setenv("PRELOADED_REPORT", str(imported))
    monkeypatch.setattr(_Process, "idle", [])
    start_early(module)
    start_early(module)  # there is one already
    started = [process.number for process in _Process.idle]
    if module != "no_such_module":
        until(imported.exists)
    with closing(ProcessSource(ToyTraffic(report=report), "toy")) as remote:
        assert_same_run(remote, ToyTraffic(), 1)
    assert started == processes(report)[:1]
    _Process.idle.pop().terminate()


def program(text, **options):
    """Start a short program with this process's import path."""
    text = (
        "from support.toy_traffic import ToyTraffic\nfrom luxloop.sim.process.process_source import ProcessSource\n"
        + text
    )
    paths = os.pathsep.join([str(TESTS), *sys.path])
    return subprocess.Popen([sys.executable, "-c", text], env={**os.environ, "PYTHONPATH": paths}, **options)


MOMENTS = {f"running {index}": f"remote.step(); time.sleep({0.002 * index})" for index in range(8)}
"""The worker computes or sends a frame when its parent is killed."""


@pytest.mark.parametrize(
    "state",
    few(["", "remote.close()", *MOMENTS.values()], MOMENTS["running 3"]),
    ids=["started", "idle", *MOMENTS],
)
def test_a_process_ends_without_temporary_files_when_its_parent_is_killed(state, tmp_path, monkeypatch):
    report, temporary = tmp_path / "report", tmp_path / "temporary"
    temporary.mkdir()
    monkeypatch.setenv("TMPDIR", str(temporary))
    parent = program(
        f"""
import os, signal, time
remote = ProcessSource(ToyTraffic(count=5000, last=-1, report={str(report)!r}, litter=True), "toy")
remote.reset(1)
{state}
os.kill(os.getpid(), signal.SIGKILL)
"""
    )
    assert parent.wait() == -signal.SIGKILL
    (child,) = processes(report)
    until(lambda: is_gone(child))
    assert list(temporary.iterdir()) == []


def test_an_idle_process_ends_with_its_parent_without_output(tmp_path):
    report = tmp_path / "report"
    parent = program(
        f"""
remote = ProcessSource(ToyTraffic(report={str(report)!r}), "toy")
remote.reset(1)
remote.close()
""",
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
    )
    assert parent.communicate() == (b"", None)
    until(lambda: is_gone(processes(report)[0]))


def test_ctrl_c_is_handled_by_the_parent_only(tmp_path):
    """The process must survive to be closed, and must not print a traceback."""
    report = tmp_path / "report"
    parent = program(
        f"""
remote = ProcessSource(ToyTraffic(last=-1, report={str(report)!r}), "toy")
remote.reset(1)
try:
    while True:
        remote.step()
except KeyboardInterrupt:
    remote.close()
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


def test_a_fork_does_not_share_its_parent_s_process(tmp_path):
    """Two readers of one pipe would each get a part of the frames."""
    report = tmp_path / "report"
    parent = program(
        f"""
import os
remote = ProcessSource(ToyTraffic(report={str(report)!r}), "toy")
remote.reset(1)
remote.close()
fork = os.fork()
remote.reset(2)
remote.close()
if fork:
    os.waitpid(fork, 0)
"""
    )
    assert parent.wait() == 0
    first, *later = processes(report)
    assert later.count(first) == 1
    assert len(set(later)) == 2


@pytest.mark.parametrize("count", [0, 100, 3000])
def test_a_frame_is_sent_as_raw_arrays(count):
    """The overhead per frame is constant: it fails if a record holds an object per actor, which is slow to pickle."""
    source = ToyTraffic(count=count)
    source.reset(1)
    frame = source.step()
    assert len(pickle.dumps(frame, protocol=5)) < sum(array.nbytes for array in arrays(frame)) + 3000


@pytest.fixture(scope="module")
def crossing():
    """Return a factory of sources of the crossing's traffic with changed settings."""
    scenario = Scenario.load(shipped.find("sumo-crossing"))
    return lambda **settings: SumoSource(replace(scenario.traffic, **settings), scenario.folder, 60.0)


@pytest.mark.parametrize("ahead", few([0, AHEAD], AHEAD))
def test_sumo_in_a_worker_equals_sumo_in_process(crossing, ahead):
    source = crossing()
    with closing(source), closing(ProcessSource(source, "SUMO", ahead)) as remote:
        assert_same_run(remote, source, 5, 60)


def test_the_worker_imports_only_what_sumo_needs(tmp_path):
    """Each library delays the start of the worker. The parent has imported all of them."""
    parent = program(
        f"""
import pathlib, numba, scipy, pandas, luxloop.scenarios.files.scenario as file
from luxloop.scenarios.files import shipped
from luxloop.sim.sumo.sumo_source import SumoSource
from support.toy_traffic import Inventory
crossing = file.Scenario.load(shipped.find("sumo-crossing"))
remote = ProcessSource(Inventory(SumoSource(crossing.traffic, crossing.folder, 60.0)), "SUMO")
remote.reset(1)
try:
    remote.step()
except Exception as end:
    pathlib.Path({str(tmp_path / "modules")!r}).write_text(str(end))
remote.close()
"""
    )
    assert parent.wait() == 0
    loaded = set((tmp_path / "modules").read_text().split())
    assert {"numpy", "libsumo", "luxloop.sim.sumo.sumo_source"} <= loaded
    heavy = {"rerun", "pandas", "pydantic", "shapely", "highway_env", "scenarios", "tracker"}
    assert loaded.isdisjoint(heavy)


@pytest.mark.slow
def test_sumo_with_a_controlled_ego_in_a_worker_equals_sumo_in_process(crossing):
    source = crossing(ego_control=True, physical=PhysicalConfig(lookahead_s=0.0))
    commands = {index: EgoCommand(speed_mps=speed) for index, speed in {5: 2.0, 20: 9.0, 21: 0.0, 40: 12.0}.items()}
    with closing(source), closing(ProcessSource(source, "SUMO", ahead=0)) as remote:
        assert_same_run(remote, source, 5, 60, commands)
        commanded, free = play(source, 5, 60, commands), play(source, 5, 60)
    assert arrays(commanded[-1])[0] == arrays(free[-1])[0]
    assert not np.array_equal(commanded[-1].ego.pose_world, free[-1].ego.pose_world), "the commands had no effect"


def test_the_start_reports_what_sumo_does():
    """The worker names the net before SUMO loads it, and counts the time that SUMO runs until the ego enters."""
    scenario = Scenario.load(shipped.find("sumo-crossing"))
    source = ProcessSource(SumoSource(scenario.traffic, scenario.folder, 200.0), "SUMO")
    reports = []
    source.report_start = reports.append

    with closing(source):
        source.reset(1)
        assert isinstance(source.step(), WorldFrame)

    net = scenario.folder / scenario.traffic.net
    assert reports[0].activity == f"SUMO loads crossing.net.xml ({net.stat().st_size / 1e6:.1f} MB)"
    assert Path(reports[0].file) == net.resolve()
    assert reports[0].process not in (None, os.getpid())
    assert reports[1].activity.startswith("SUMO runs until the ego enters, at most 300 s")
    assert 0.0 <= reports[1].share < 1.0


def test_a_worker_whose_parent_dies_within_a_request_leaves_no_folder(tmp_path):
    scratch = tmp_path / "scratch"
    program = f"from luxloop.sim.process.worker import serve; serve({str(scratch)!r})"
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
    request = pickle.dumps(Preload("m" * 1000), protocol=5)
    with subprocess.Popen([sys.executable, "-c", program], stdin=subprocess.PIPE, env=environment) as worker:
        until(scratch.is_dir)
        worker.stdin.write(request[:-500])
        worker.stdin.close()
        assert worker.wait(timeout=60) == 0
    assert not scratch.exists()
