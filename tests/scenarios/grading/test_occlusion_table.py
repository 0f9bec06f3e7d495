"""Table of occlusions: hand-made frames with known blockers, and the staged truck of a shipped scenario."""

import math

import numpy as np
import pytest
from support.frames import DT, Body, Scripted, follow, grade_run

from luxloop.scenarios.files import shipped
from luxloop.scenarios.files.scenario import Scenario
from luxloop.scenarios.grading.grading_config import GradingConfig
from luxloop.scenarios.grading.occlusions import COLUMNS, STATIC, UnitView, manoeuvre, occlusion_table
from luxloop.scenarios.run import device, loop
from luxloop.scenarios.run.device import SHIPPED
from luxloop.sim.world import Kind

HIDDEN = range(5, 15)
TABLES = ("truth", "tracks")


def car_behind(*others, frames=25, track_after=4, x=20.0):
    """Grade a car at (x, 0) that is hidden in the frames `HIDDEN`, with other bodies in the scene."""
    scene = [
        [Body(0, x, 0.0, visible=float(i not in HIDDEN), points=20 * (i not in HIDDEN), speed=3.0), *others]
        for i in range(frames)
    ]
    script = [
        [] if i in HIDDEN else [follow(scene[i][0], track_id=4 if i < HIDDEN.start else track_after, x=1.02 * x)]
        for i in range(frames)
    ]
    return grade_run(scene, Scripted(script))


@pytest.mark.parametrize("side", [1, -1])
def test_the_blocker_with_most_points_between_unit_and_vehicle_is_named(side):
    """The points of a body lie at its centre; the car spans about 3 degrees to either side, also across +-pi behind."""
    van = Body(1, 10.0 * side, 0.2, points=12, kind=Kind.VAN)
    bus = Body(2, 12.0 * side, -0.1, points=30, kind=Kind.BUS)
    behind, beside = Body(3, 26.0 * side, 0.0, points=90), Body(4, 10.0 * side, 3.0, points=90)
    metrics, tables, _ = car_behind(van, bus, behind, beside, x=20.0 * side)
    (row,) = tables["occlusions"].to_dict("records")
    assert (row["hidden_by_id"], row["hidden_by"], row["hidden_by_kind"]) == (2, "car2", "bus")
    assert row["hidden_by_share"] == pytest.approx(30 / 42)
    assert (row["frame"], row["time_s"], row["end_frame"]) == (4, pytest.approx(4 * DT), 15)
    assert (row["gap_s"], row["hidden_s"]) == (pytest.approx(11 * DT), pytest.approx(10 * DT))
    assert (row["visible_before"], row["visible_min"]) == (1.0, 0.0)
    assert (row["range_m"], row["speed_mps"], row["manoeuvre"]) == (20.0, 3.0, "keeps")
    assert (row["track_id"], row["survived"], row["track_id_after"], row["reacquired_s"]) == (4, True, 4, 0.0)
    assert row["position_error_m"] == pytest.approx(0.4)
    assert row["heading_error_deg"] == pytest.approx(0.0)
    assert metrics["track.occlusion_survival"].n == 1


def test_points_are_in_front_of_a_turned_box_between_its_outermost_corners():
    """A truck of 16 m, turned by 0.5 rad: its corners as complex numbers, seen from a unit at (1, -2)."""
    corners = 20.0 + np.array([8 + 1.25j, 8 - 1.25j, -8 - 1.25j, -8 + 1.25j]) * np.exp(0.5j)
    bearing = np.angle(corners - (1 - 2j))
    points = np.array([bearing.min() - 0.01, bearing.min() + 0.01, bearing.max() - 0.01, bearing.max() + 0.01, 0.1])
    view = UnitView(np.array([1.0, -2.0]), np.arange(5), np.array([5.0, 5.0, 5.0, 5.0, 30.0]), points)
    assert view.in_front(np.array([20.0, 0.0, 0.5, 16.0, 2.5])).tolist() == [1, 2]


def test_another_track_is_a_switch_and_no_points_in_between_is_an_unnamed_blocker():
    (row,) = car_behind(track_after=9)[1]["occlusions"].to_dict("records")
    assert (row["survived"], row["track_id"], row["track_id_after"]) == (False, 4, 9)
    assert (row["hidden_by_id"], row["hidden_by"]) == (-1, "")
    assert math.isnan(row["hidden_by_share"])


def test_a_run_without_occlusions_has_an_empty_table_of_the_same_types():
    empty, full = grade_run([], Scripted([]))[1]["occlusions"], car_behind()[1]["occlusions"]
    assert list(empty.columns) == list(COLUMNS) == list(full.columns)
    assert len(empty) == 0
    assert empty.dtypes.astype(str).tolist() == full.dtypes.astype(str).tolist()


def test_a_frame_counts_as_hidden_until_the_next_one():
    """Scans of recordings are not evenly spaced: the last hidden one lasts for half a second more."""
    tables = car_behind()[1]
    truth, tracks = (tables[name].assign(time_s=lambda t: t["time_s"] + 0.5 * (t["frame"] > 14)) for name in TABLES)
    (row,) = occlusion_table(truth, tracks, GradingConfig(), tables["blockers"]).to_dict("records")
    assert row["hidden_s"] == pytest.approx(10 * DT + 0.5)
    assert row["gap_s"] == pytest.approx(11 * DT + 0.5)


def rows(x, y, yaw, changes=False):
    t = np.arange(len(x)) * 0.1
    velocity = {"vx_world_mps": np.gradient(x, t), "vy_world_mps": np.gradient(y, t)}
    place = {"time_s": t, "x_world_m": x, "y_world_m": y, "yaw_world_rad": yaw, "changes_lane": np.array([changes])}
    return place | velocity


@pytest.mark.parametrize("start", [0.0, 2.0, math.pi - 0.01, -math.pi + 0.01])
def test_manoeuvres_by_their_definition(start):
    """In any direction; yaws of the table are in (-pi, pi]."""

    def driven(x, y, yaw, **changes):
        place = (x + 1j * y) * np.exp(1j * start)
        return manoeuvre(rows(place.real, place.imag, np.angle(np.exp(1j * (start + yaw))), **changes))

    t, zero = np.arange(21) * 0.1, np.zeros(21)
    sway = 0.03 * np.linspace(-1.0, 1.0, 21)
    assert driven(10 * t, zero, sway) == "keeps"
    assert driven(10 * t - t**2, zero, zero) == "brakes"
    assert driven(5 * t + 0.5 * t**2, zero, zero) == "accelerates"
    assert driven(10 * np.sin(t / 2), 10 - 10 * np.cos(t / 2), t / 2) == "turns"
    assert driven(10 * np.sin(t / 2), 10 * np.cos(t / 2) - 10, -t / 2) == "turns"
    assert driven(10 * t, 1.75 * (1 - np.cos(np.pi * t / 2)), zero) == "changes lane"
    assert driven(10 * t, zero, zero, changes=True) == "changes lane"


@pytest.mark.parametrize(("name", "blocker", "kind"), [("truck-shadow-1s", "truck", "truck")])
def test_the_sensor_s_truth_names_the_blocker_of_a_staged_scene(name, blocker, kind):
    result = loop.run(Scenario.load(shipped.find(name)), device.load(SHIPPED))
    (row,) = result.tables["occlusions"].to_dict("records")
    assert (row["name"], row["hidden_by"], row["hidden_by_kind"]) == ("hidden car", blocker, kind)
    assert row["hidden_by_share"] == 1.0


def test_a_wall_is_a_static_obstacle():
    from luxloop.scenarios.study.scenes.hidden_vehicles import hidden_behind_wall

    document = hidden_behind_wall(1.0, 10.0, "brakes") | {"seed": 1}
    result = loop.run(Scenario.of(document, shipped.CATALOG / "wall.toml"), device.load(SHIPPED))
    (row,) = result.tables["occlusions"].to_dict("records")
    assert (row["hidden_by"], row["hidden_by_kind"], row["hidden_by_id"]) == (STATIC, "obstacle", -1)
    assert row["manoeuvre"] == "brakes"
    assert row["gap_s"] == pytest.approx(1.0, abs=0.5)
    assert row["survived"] == (result.metrics["track.occlusion_survival"].value == 1.0)
