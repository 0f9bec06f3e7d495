"""The run loop: its results, bit-identical repetition, and the interface of a tracker."""

import tomllib
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest
from support import short_run

from luxloop.scenarios.errors import ContractError, InputError, ScenarioError
from luxloop.scenarios.files import shipped
from luxloop.scenarios.files.scenario import Scenario
from luxloop.scenarios.metrics.definitions import find_metric, standard_names
from luxloop.scenarios.report.run_document import truth_events
from luxloop.scenarios.run import device, loop, versions, warm_up
from luxloop.scenarios.run.stopwatch import RECORDING, Stopwatch
from luxloop.scenarios.run.trace_hash import TraceHash
from luxloop.sim.world import Actors, Collision, Ego
from luxloop.tracker.records import TURNING_MODELS
from luxloop.tracker.tracker import Tracker

CROSSING = shipped.CATALOG / "urban" / "sumo-crossing"
GRADED = {
    name
    for name in standard_names()
    if find_metric(name).parameters.get("model") not in TURNING_MODELS and not find_metric(name).definition.needs
}
"""Figures of a run with the standard motion models."""


def test_a_result_has_every_metric_with_its_unit_or_the_reason_for_no_value():
    metrics = short_run.result().metrics
    assert metrics.keys() == GRADED
    for name, metric in metrics.items():
        assert metric.unit == find_metric(name).unit
        assert (metric.value is None) == bool(metric.reason), name


def test_the_duration_sets_the_number_of_frames():
    result = short_run.result()
    assert result.frames == result.tables["truth"]["frame"].nunique() == short_run.FRAMES
    assert result.complete


def test_the_effective_config_has_rig_device_and_defaults():
    config = short_run.result().config
    assert len(config["rig"]["mounts"]) == 6
    assert config["device"] == device.SHIPPED
    assert config["grading"]["range_max_m"] == 50.0
    assert config["seed"] == 4


def test_the_same_seed_gives_the_same_run_and_a_recording_does_not_change_it(tmp_path):
    once, again = short_run.result(), short_run.run(record_to=tmp_path / "recording.rrd")
    assert (tmp_path / "recording.rrd").stat().st_size > 0
    assert again.trace_hash == once.trace_hash
    for name in GRADED:
        assert name.startswith("perf.") or again.metrics[name] == once.metrics[name], name


def test_another_seed_gives_another_trace():
    assert short_run.run(seed=5).trace_hash != short_run.result().trace_hash


def test_tracker_settings_change_the_trace():
    text = short_run.TEXT + "\n[tracker.confirmation]\nconfirm_hits = 100\n"
    assert short_run.run(text).trace_hash != short_run.result().trace_hash


def arriving_ego(folder, attributes):
    """Scenario of an ego on the crossing's northern exit, which is its only edge."""
    ego = f'<vehicle id="ego" depart="0" {attributes}><route edges="north_out"/></vehicle>'
    (folder / "ego.rou.xml").write_text(f"<routes>{ego}</routes>")
    return f"""
description = "The ego arrives."
duration_s = 60
[traffic]
kind = "sumo"
net = "{CROSSING / "crossing.net.xml"}"
routes = ["{folder / "ego.rou.xml"}"]
"""


def test_traffic_that_ends_early_makes_an_incomplete_result(tmp_path):
    """The ego starts a few metres before the end of its edge."""
    result = short_run.run(arriving_ego(tmp_path, 'departPos="-12" departSpeed="10"'))
    assert not result.complete
    assert not result.simulator_failed
    assert "ego" in result.ended_early
    assert 2 < result.frames < 50


def test_traffic_that_ends_after_its_first_frame_is_graded(tmp_path):
    """The ego starts at its destination."""
    result = short_run.run(arriving_ego(tmp_path, 'departPos="60" arrivalPos="60"'))
    assert result.frames == 1
    assert result.ended_early.startswith('ego "ego" left the net at 0.08 s')
    assert result.metrics.keys() == GRADED


def write_collision(folder, standing, driving):
    """Write routes of a vehicle that cannot brake for another one, hit.rou.xml."""
    (folder / "hit.rou.xml").write_text(f"""<routes>
        <vType id="blind" sigma="0" speedDev="0" decel="0.2" emergencyDecel="0.2" apparentDecel="0.2"
            lcStrategic="-1" lcSpeedGain="0" lcKeepRight="0" lcCooperative="-1"/>
        <vehicle id="{standing}" depart="0" departPos="stop" departLane="1"><route edges="north_out"/>
            <stop lane="north_out_1" startPos="60" endPos="80" duration="99"/></vehicle>
        <vehicle id="{driving}" type="blind" depart="0.4" departPos="60" departLane="1" departSpeed="9"
            insertionChecks="none"><route edges="north_out"/></vehicle></routes>""")


def test_a_car_that_hits_the_ego_is_counted_and_named_by_the_report(tmp_path):
    """SUMO teleports it by default, before the bodies overlap."""
    write_collision(tmp_path, standing="ego", driving="hitter")
    text = arriving_ego(tmp_path, "").replace("ego.rou.xml", "hit.rou.xml").replace("= 60", "= 2.4")
    result = short_run.run(text)
    assert result.metrics["sim.ego_collisions"].value == 1.0
    assert "1 collision of the ego (hitter, at 8.7 m/s at " in str(truth_events(result)[0])


@pytest.mark.parametrize("ahead", [False, True])
def test_an_ego_that_hits_a_car_is_counted_in_a_run_that_ends_by_it(tmp_path, ahead):
    """The collision comes with the end, out of one or two processes."""
    write_collision(tmp_path, standing="halted", driving="ego")
    text = arriving_ego(tmp_path, "").replace("ego.rou.xml", "hit.rou.xml") + 'ego = "vehicle:ego"\n'
    scenario = Scenario.load(short_run.write(tmp_path, text))
    result = loop.run(scenario, device.load(device.SHIPPED), ahead=ahead)
    assert 'it collided with "halted"' in result.ended_early
    assert result.metrics["sim.ego_collisions"].value == 1.0
    (event,) = result.tables["events"].to_dict("records")
    assert (event["kind"], event["name"], event["frame"]) == ("ego_collision", "halted", result.frames - 1)


class WithoutTrace:
    """The shipped tracker, without its trace."""

    def __init__(self, config):
        self.tracker, self.times = Tracker(config), []

    def step(self, scan):
        self.times.append(scan.time)
        return self.tracker.step(scan)[0]


def test_a_tracker_without_a_trace_is_graded_by_its_tracks_only():
    result = short_run.run(factory=WithoutTrace)
    assert result.metrics["fit.heading_abs_mean_deg"].value is None
    assert "does not report a trace" in result.metrics["fit.heading_abs_mean_deg"].reason
    assert result.metrics["track.hota"] == short_run.result().metrics["track.hota"]
    assert result.trace_hash == short_run.result().trace_hash


def test_the_warm_up_uses_another_tracker_than_the_run():
    made = []

    def factory(config):
        made.append(WithoutTrace(config))
        return made[-1]

    short_run.run(factory=factory)
    warmed_up, graded = made
    assert len(warmed_up.times) == warm_up.FRAMES
    np.testing.assert_allclose(graded.times, 0.08 * np.arange(short_run.FRAMES))


class Mistaken:
    """Returns a value that is not tracks."""

    def __init__(self, config):
        del config

    def step(self, scan):
        return {"tracks": len(scan)}


def test_a_tracker_that_returns_no_tracks_is_an_error():
    with pytest.raises(ContractError, match=r"Mistaken\.step: .* returned dict; return Tracks or \(Tracks"):
        short_run.run(factory=Mistaken)


@dataclass
class Record:
    """A record with two fields of one type."""

    a: np.ndarray
    b: np.ndarray
    time: float = 0.0


@dataclass(frozen=True, eq=False)
class Before:
    """A frame of the world without collisions."""

    index: int
    time: float
    ego: Ego
    actors: Actors


def hash_of(*records):
    trace = TraceHash()
    trace.add(*records)
    return trace.hexdigest()


def test_the_trace_hash_depends_on_values_types_shapes_fields_and_order():
    one, two = np.array([1.0]), np.array([2.0])
    base = Record(one, two)
    different = [
        Record(two, one),
        Record(np.array([1.0, 2.0]), np.empty(0)),
        Record(one[None], two),
        Record(one.view(np.int64), two),
        Record(one, two, time=1e-300),
        Record(one, two, time=0),
        Record(one, np.array([np.nextafter(2.0, 3.0)])),
    ]
    hashes = {hash_of(record) for record in (base, *different)}
    assert len(hashes) == 1 + len(different)
    assert hash_of(base, different[0]) != hash_of(different[0], base)


def test_the_trace_hash_does_not_depend_on_memory_layout():
    matrix = np.arange(6.0).reshape(2, 3)
    assert hash_of(Record(matrix, matrix)) == hash_of(Record(np.asfortranarray(matrix), matrix.copy()))


def test_the_trace_hash_distinguishes_none_from_an_empty_array():
    assert len({hash_of(Record(np.zeros(1), other)) for other in (None, np.empty(0))}) == 2


def test_the_trace_hash_contains_collisions_and_is_that_of_a_frame_without_the_field_if_there_are_none():
    frame, hit = warm_up.car_ahead(0), Collision(id=1, name="car", speed_mps=9.0)
    hashes = [hash_of(replace(frame, collisions=hits)) for hits in ((), (hit,), (hit, hit), (replace(hit, name="x"),))]
    assert len(set(hashes)) == 4
    assert hashes[0] == hash_of(Before(frame.index, frame.time, frame.ego, frame.actors))


def test_the_trace_hash_refuses_other_types():
    with pytest.raises(TypeError, match="b: cannot hash a set"):
        hash_of(Record(np.zeros(1), {1, 2}))


def test_the_real_time_factor_excludes_recording(monkeypatch):
    """Two frames of 0.1 s: stages take 10, 20 and 30 ms, grading 40 ms, recording 500 ms: 0.2 s in 0.2 s."""
    clock = Clock()
    monkeypatch.setattr("time.perf_counter", clock)
    stopwatch = Stopwatch()
    for _ in range(2):
        for stage, seconds in {"sim": 0.01, "sensor": 0.02, "tracker": 0.03}.items():
            stopwatch.time(stage, clock.wait, seconds)
        clock.wait(0.04)
        stopwatch.time(RECORDING, clock.wait, 0.5)
    metrics = stopwatch.metrics(frames=2, dt=0.1)
    assert metrics["perf.realtime_factor"].value == pytest.approx(1.0)
    assert metrics["perf.sensor_ms_p50"].value == pytest.approx(20.0)


class Clock:
    """A clock that is advanced by hand."""

    now = 100.0

    def __call__(self):
        return self.now

    def wait(self, seconds):
        self.now += seconds


# --- what a result rests on


@pytest.mark.parametrize(
    ("name", "before", "after", "message"),
    [
        ("short.toml", "max = 0.5", "max = 0.9", "short.toml: was changed after it was read"),
        ("rig.toml", "z_m = 0.55", "z_m = 0.65", "its rig rig.toml was changed during the run"),
    ],
)
def test_a_file_that_changes_during_the_run_is_one_line_and_no_result(tmp_path, name, before, after, message):
    rig = 'rear_axle_x_m = -1.385\nmodel = "lux"\n[[unit]]\nname = "front"\nx_m = 3.55\ny_m = 0.0\nz_m = 0.55\n'
    (tmp_path / "rig.toml").write_text(rig + "yaw_deg = 0.0\npitch_deg = 0.0\nroll_deg = 0.0\n")
    limits = '[rig]\nfile = "rig.toml"\n[expect]\n"track.missed_share" = { max = 0.5 }\n'
    scenario = Scenario.load(short_run.write(tmp_path, short_run.TEXT + limits))

    def change(*_frame):
        text = (tmp_path / name).read_text()
        (tmp_path / name).write_text(text.replace(before, after))

    with pytest.raises(ScenarioError, match=message):
        loop.run(scenario, device.NoTracks, export=change)


def test_a_package_that_is_replaced_during_the_run_is_one_line_and_no_result(monkeypatch):
    def replace_numpy(*_frame):
        monkeypatch.setattr(versions, "version", lambda package: "0.1" if package == "numpy" else found[package])

    found = versions.installed()
    scenario = Scenario.of(tomllib.loads(short_run.TEXT), Path("short.toml"))
    with pytest.raises(InputError, match=rf"numpy {found['numpy']} was replaced by 0.1 during the run; run it again"):
        loop.run(scenario, device.NoTracks, export=replace_numpy)
