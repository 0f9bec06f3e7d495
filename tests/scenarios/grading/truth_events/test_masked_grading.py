"""Grading of vehicles that appear, vanish or overlap in view, and the report of their events."""

import math
from dataclasses import replace

import numpy as np
import pytest
from support import short_run
from support.few import few
from support.frames import DT, Body, Scripted, follow, make_frames, observe

from luxloop.scenarios.document.document import plain
from luxloop.scenarios.files.expect import check
from luxloop.scenarios.grading import grader as grading
from luxloop.scenarios.grading.grader import Grader
from luxloop.scenarios.grading.grading_config import GradingConfig
from luxloop.scenarios.grading.truth_events.truth_event import MASK_S
from luxloop.scenarios.report import text
from luxloop.scenarios.report.run_document import truth_events
from luxloop.scenarios.run import run_folder

MASKED = math.ceil(MASK_S / DT - 1e-9)
"""Frames of a mask."""


def graded(scene, reports, delivered_m=200.0):
    """Grade a tracker that reports the given tracks in each frame; return metrics and tables."""
    grader = Grader(GradingConfig(), delivered_m=delivered_m)
    tracker = Scripted(reports)
    for bodies, frame in zip(scene, make_frames(scene), strict=True):
        scan, truth = observe(frame, bodies)
        grader.add(frame, scan, truth, *tracker.step(scan))
    return grader.finish()


def standing(n=1, x=10.0, **keys):
    return Body(n, x, 5.0, **keys)


def test_a_vehicle_that_appears_in_view_is_not_missed_before_it_can_be_confirmed():
    scene = [[standing()] if n >= 5 else [] for n in range(30)]
    reports = [[follow(standing())] if n >= 5 + MASKED else [] for n in range(30)]
    metrics, tables = graded(scene, reports)
    assert metrics["sim.insertions_in_view"].value == 1
    assert metrics["sim.masked_observations"].value == MASKED
    assert metrics["track.missed"].value == 0
    assert tables["truth"]["graded"].tolist() == [False] * MASKED + [True] * (25 - MASKED)
    plain, _ = graded(scene, reports, delivered_m=None)
    assert plain["track.missed"].value == MASKED
    assert plain["sim.insertions_in_view"].value is None


def test_a_track_of_a_masked_vehicle_is_not_false():
    scene = [[standing()] if n >= 5 else [] for n in range(12)]
    metrics, tables = graded(scene, [[follow(standing())] if n >= 6 else [] for n in range(12)])
    assert set(tables["tracks"]["verdict"]) == {"ungraded"}
    assert metrics["track.false"].value in (None, 0)


def test_a_track_where_a_vehicle_vanished_in_view_is_not_false_for_a_time():
    scene = [[standing(2, x=-15.0), *([standing()] if n < 5 else [])] for n in range(30)]
    reports = [[follow(standing(2, x=-15.0)), follow(standing())]] * 30
    metrics, tables = graded(scene, reports)
    assert metrics["sim.removals_in_view"].value == 1
    orphan = tables["tracks"][tables["tracks"]["track_id"] == 1]
    assert orphan["verdict"].tolist()[:5] == ["graded"] * 5
    false = orphan["verdict"].tolist().count("false")
    assert orphan["verdict"].tolist()[-false:] == ["false"] * false
    assert metrics["track.false"].value == false == 25 - math.floor(MASK_S / DT + 1e-9)  # from its last frame on


def test_vehicles_are_not_graded_while_they_overlap():
    # 5 m/s, from 2 m behind to 1.6 m ahead of the standing car's centre, in its place
    scene = [[standing(), Body(2, 4.0 + 5.0 * DT * n, 5.0, speed=5.0)] for n in range(30)]
    metrics, tables = graded(scene, [[follow(body) for body in bodies] for bodies in scene])
    apart = np.array([abs(4.0 + 5.0 * DT * n - 10.0) for n in range(30)])
    overlap = (4.6 - apart) * 1.8 > 0.05
    assert tables["truth"]["graded"].to_numpy().reshape(30, 2).all(axis=1).tolist() == (~overlap).tolist()
    assert metrics["sim.overlaps"].value == 1
    assert metrics["sim.overlap_max_m2"].value == pytest.approx((4.6 - apart.min()) * 1.8)
    assert metrics["sim.masked_observations"].value == 2 * overlap.sum()
    assert metrics["track.missed"].value == metrics["track.id_switches"].value == 0


def test_metrics_are_the_same_from_the_tables():
    scene = [[standing(), Body(2, 4.0 + 5.0 * DT * n, 5.0, speed=5.0)] if n >= 5 else [] for n in range(30)]
    metrics, tables = graded(scene, [[follow(body) for body in bodies] for bodies in scene])
    again = grading.grade(tables, GradingConfig(), 30)
    assert {name: again[name] for name in again if name.startswith("sim.")} == {
        name: metrics[name] for name in metrics if name.startswith("sim.")
    }


COLLISION = """\
description = "The ego drives through a standing car."
duration_s = 3.2
[traffic]
kind = "scripted"
ego = { motion = [{ kind = "straight", speed_mps = 10.0 }] }
[[traffic.actor]]
name = "parked"
x_m = 16
y_m = 0.5
[expect]
"sim.ego_collisions" = { max = 0 }
"sim.limit_violations" = { max = 0 }
"""


def test_a_run_in_which_the_ego_drives_through_a_car_fails_and_says_so(tmp_path):
    result = short_run.run(COLLISION)
    scenario_checks = check(result.metrics, _limits(result), result.config["device"])
    assert {one.name: one.outcome for one in scenario_checks} == {
        "sim.ego_collisions": "failed",
        "sim.limit_violations": "passed",
    }
    (line,) = truth_events(result)
    assert plain(line.words).startswith("Traffic events: 1 collision of the ego (parked, ")
    assert plain(line.words) in " ".join(text.as_text(text.report(result, scenario_checks)).split())
    run_folder.write(tmp_path, result, scenario_checks, "")
    (event,) = run_folder.read(tmp_path).tables["events"].to_dict("records")
    assert (event["kind"], event["name"]) == ("ego_collision", "parked")


ROUNDABOUT = """\
description = "A roundabout by highway-env."
seed = 2
duration_s = 3.2
[traffic]
kind = "highway-env"
env = "roundabout-v1"
"""
CHOSEN = '[traffic.config]\nother_vehicles_type = "highway_env.vehicle.behavior.AggressiveVehicle"\n'
REMEDY = 'set traffic.config.other_vehicles_type = "luxloop.sim.highway.motorist.Motorist"'


@pytest.mark.parametrize("config", few(["", CHOSEN], ""))
def test_violations_by_drivers_of_highway_env_point_to_the_motorist(config):
    line = plain(truth_events(short_run.run(ROUNDABOUT + config))[-1].words)
    assert "of limits (" in line
    assert line.endswith(REMEDY)


def test_violations_by_other_drivers_and_other_events_do_not():
    result = short_run.run(ROUNDABOUT)
    events = result.tables["events"]
    others = events.assign(kind="overlap")
    traffic = result.config["traffic"] | {"config": {"other_vehicles_type": "mine.Driver"}}
    for changed in (
        replace(result, tables={"events": others}),
        replace(result, config={"traffic": traffic}),
        replace(result, config={"traffic": {"kind": "sumo", "config": "a.sumocfg"}}),
        replace(result, config={}),
    ):
        assert REMEDY not in plain(truth_events(changed)[-1].words)


def test_a_run_without_events_has_no_line():
    result = short_run.result()
    assert truth_events(result) == []
    assert result.metrics["sim.overlaps"].value == 0
    assert result.metrics["sim.acceleration_max_mps2"].value == pytest.approx(0.0, abs=1e-9)


def _limits(result):
    from luxloop.scenarios.files.expect import Limit

    return {name: Limit(**limit) for name, limit in result.config["expect"].items()}
