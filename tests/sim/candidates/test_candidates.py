"""Figures of the candidates for the ego, against figures by hand."""

import math

import numpy as np
import pytest

from luxloop.sim.candidates.candidate_log import CandidateLog, count_blocked, count_near
from luxloop.sim.candidates.candidates import Body, Moment
from luxloop.sim.candidates.want import Want


def body(name, *, graded=True, rejected=False):
    return Body(name, "passenger", (4.0, 2.0), graded, rejected)


def log_of(moments, range_m=200.0, near_m=50.0):
    """Return the candidates of moments, each a dictionary from name to (x, y, yaw in degrees, speed)."""
    log, number = CandidateLog(range_m, near_m), {}
    for time, vehicles in moments:
        new = [name for name in vehicles if name not in number]
        number |= {name: len(number) + k for k, name in enumerate(new)}
        rows = np.array(list(vehicles.values()), dtype=float).reshape(-1, 4)
        pose = np.column_stack([rows[:, :2], np.radians(rows[:, 2])])
        bodies = [body(name, graded=not name.startswith("bike"), rejected=name.startswith("bike")) for name in new]
        log.add(Moment(time, bodies, np.array([number[name] for name in vehicles], dtype=int), pose, rows[:, 3]))
    return log.candidates()


def by_name(found):
    return {body.name: row for row, body in enumerate(found.bodies)}


# ---- lines of sight


def blocked_by_sampling(pose, size, range_m):
    """Count blocked lines by testing 2001 points of each line against each box."""
    count = np.zeros(len(pose), dtype=int)
    share = np.linspace(0.0, 1.0, 2001)[:, None]
    for ego, target in np.ndindex(len(pose), len(pose)):
        if ego == target or math.dist(pose[ego, :2], pose[target, :2]) > range_m:
            continue
        line = pose[ego, :2] + share * (pose[target, :2] - pose[ego, :2])
        for other in set(range(len(pose))) - {ego, target}:
            cos, sin = math.cos(pose[other, 2]), math.sin(pose[other, 2])
            x, y = (line - pose[other, :2]).T
            inside = np.abs(x * cos + y * sin) <= 0.5 * size[other, 0]
            if (inside & (np.abs(y * cos - x * sin) <= 0.5 * size[other, 1])).any():
                count[ego] += 1
                break
    return count


def test_a_car_behind_a_truck_is_hidden_and_one_beside_it_is_not():
    pose = np.array([[0.0, 0, 0], [15.0, 0, 0], [30.0, 0, 0], [30.0, 8.0, 0]])
    size = np.array([[4.0, 2.0], [10.0, 2.5], [4.0, 2.0], [4.0, 2.0]])
    # the line to the fourth body is at y = 8 / 30 * 20 = 5.3 m where the truck ends at x = 20 m
    everyone = np.ones(4, dtype=bool)
    assert count_near(pose[:, :2], everyone, 50.0).tolist() == [3, 3, 3, 3]
    assert count_blocked(pose, size, everyone, 50.0).tolist() == [1, 0, 1, 0]
    # a hidden body that does not count, and one out of range
    assert count_blocked(pose, size, np.array([True, True, False, True]), 50.0).tolist() == [0, 0, 1, 0]
    assert count_blocked(pose, size, everyone, 29.0).tolist() == [0, 0, 0, 0]


def test_blocked_lines_equal_those_by_sampling(monkeypatch):
    draws = np.random.default_rng(5)
    pose = np.column_stack([draws.uniform(0, 60, (40, 2)), draws.uniform(-3, 3, 40)])
    size = np.column_stack([draws.uniform(3, 12, 40), draws.uniform(1.5, 2.6, 40)])
    everyone = np.ones(40, dtype=bool)
    expected = blocked_by_sampling(pose, size, 40.0)
    assert expected.sum() > 200
    # a sampled line may miss the corner of a box
    assert np.abs(count_blocked(pose, size, everyone, 40.0) - expected).sum() <= 0.003 * expected.sum()
    whole = count_blocked(pose, size, everyone, 40.0)
    monkeypatch.setattr("luxloop.sim.candidates.candidate_log.CHUNK", 100)
    assert (count_blocked(pose, size, everyone, 40.0) == whole).all()


def test_no_vehicles_have_no_neighbours():
    assert count_near(np.empty((0, 2)), np.empty(0, bool), 50.0).tolist() == []
    assert count_blocked(np.empty((0, 3)), np.empty((0, 2)), np.empty(0, bool), 50.0).tolist() == []


# ---- figures


def test_stay_distance_and_neighbours():
    # "a" drives 10 m/s for 10 s; "b" stands at x = 30 m, 0.5 s later; the bicycle does not count
    moments = [
        (
            float(t),
            {"a": (10.0 * t, 0, 0, 10.0), "bike": (5.0, 3.0, 0, 0.0)} | ({"b": (30.0, 9.0, 0, 0.0)} if t > 2 else {}),
        )
        for t in range(11)
    ]
    moments += [(float(t), {"b": (30.0, 9.0, 0, 0.0)}) for t in range(11, 15)]
    found = log_of(moments, range_m=60.0, near_m=21.0)
    a, b = (by_name(found)[name] for name in "ab")
    assert (found.enters_s[a], found.stay_s[a], found.leaves[a]) == (0.0, 10.0, True)
    assert (found.enters_s[b], found.stay_s[b], found.leaves[b]) == (3.0, 11.0, False)
    assert found.distance_m[a] == pytest.approx(100.0)
    assert found.distance_m[b] == 0.0
    # of 11 moments of "a", "b" is within 60 m in those from 3 s to 8 s, and within 21 m in those from 3 s to 4 s
    assert found.neighbours[a] == pytest.approx(6 / 11)
    assert found.near[a] == pytest.approx(2 / 11)
    assert found.suitable.tolist() == [True, False, True]


def test_turns_and_stops():
    yaw = [0, 0, 10, 20, 20, 20, 20, 24, 24, 24, 24]  # two of ten seconds at 10 deg/s; 4 deg/s is no turn
    speed = [
        5,
        5,
        5,
        5,
        0.4,
        0.2,
        0.4,
        0.6,
        5,
        0.1,
        5,
    ]  # stops at 5 s and at 9 s, not at 4 s: 0.4 is between the limits
    moments = [(float(t), {"a": (t, 0, yaw[t], speed[t]), "still": (0, 90, 0, 0.0)}) for t in range(11)]
    found = log_of(moments)
    assert found.turns[by_name(found)["a"]] == pytest.approx(0.2)
    assert found.stops[by_name(found)["a"]] == 2
    assert (found.stops[by_name(found)["still"]], found.turns[by_name(found)["still"]]) == (0, 0.0)


def test_a_yaw_that_wraps_is_no_turn():
    moments = [(float(t), {"a": (-5 * t, 0, 179.0 if t % 2 else -179.0, 5.0)}) for t in range(6)]
    assert log_of(moments).turns.tolist() == [0.0]


def test_occlusion_is_the_share_of_hidden_neighbours():
    row = {"a": (0, 0, 0, 5.0), "wall": (12, 0, 0, 5.0), "b": (24, 0, 0, 5.0)}
    apart = row | {"wall": (12, 9, 0, 5.0)}
    found = log_of([(0.0, row), (1.0, apart), (2.0, apart), (3.0, row)])
    # two neighbours in four moments, one of them hidden in two
    assert found.occlusion[by_name(found)["a"]] == pytest.approx(2 / 8)
    assert found.occlusion[by_name(found)["wall"]] == 0.0


# ---- order


def test_the_order_prefers_suitable_then_usable_then_the_wanted():
    many = {f"other{n}": (3.0 * n, 20.0, 0, 2.0) for n in range(4)}
    moments = []
    for t in range(41):
        vehicles = {"bike": (0, 0, 0, 5.0), "parked": (5, 0, 0, 0.0), "few": (400 + 2.0 * t, 0, 0, 2.0)}
        if t < 20:
            vehicles["short"] = (2, 0, 0, 5.0)
        moments.append((float(t), vehicles | many))
    found = log_of(moments)
    names = [found.bodies[row].name for row in found.order(Want.NEIGHBOURS, 30.0)]
    assert names[:4] == ["other0", "other1", "other2", "other3"]  # equal in all: by name
    assert names[4] == "few"  # alone, but it drives for 40 s
    assert set(names[5:7]) == {"short", "parked"}
    assert names[-1] == "bike"
    assert found.bodies[found.order(Want.NEIGHBOURS, 10.0)[0]].name == "short"
    assert log_of([]).order().tolist() == []


def test_the_busiest_window_has_the_most_neighbours_while_the_vehicle_drives():
    moments = []
    for t in range(31):
        speed = 0.0 if t >= 20 else 5.0
        vehicles = {"a": (5.0 * min(t, 20), 0, 0, speed)}
        vehicles |= {"b": (50.0, 9.0, 0, 0.0), "c": (50.0, 18.0, 0, 0.0)} if 8 <= t <= 12 or t >= 20 else {}
        moments.append((float(t), vehicles))
    found = log_of(moments)
    assert found.busiest_start(by_name(found)["a"], 4.0) == (8.0, 2.0)
    start, mean = found.busiest_start(by_name(found)["b"], 100.0)  # longer than its stay
    assert start == 8.0
    assert mean == pytest.approx((5 * 2 + 11 * 1) / 16)  # "a" is within 50 m in 5 of its 16 moments, "c" in all
