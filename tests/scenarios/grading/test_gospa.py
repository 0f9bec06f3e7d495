"""GOSPA: by hand, and against all possible assignments."""

from itertools import permutations

import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st
from support.frames import Body, Estimate, Scripted, follow, grade_run

from luxloop.scenarios.grading import gospa
from luxloop.scenarios.grading.grading_config import GradingConfig
from luxloop.sensor_model.truth import View
from luxloop.sim.world import Kind


def at(points, frame=0):
    return pd.DataFrame(points, columns=gospa.POSITION, dtype=float).assign(frame=frame)


def metrics_of(scene, script, **options):
    return grade_run(scene, Scripted(script), **options)[0]


def values(metrics, *names):
    return [metrics[f"track.{name}"].value for name in names]


PARTS = ("gospa_localisation_m2", "gospa_missed_m2", "gospa_false_m2")


def test_one_located_one_missed_and_one_false():
    """The squared cut-off of 2 m is 4 m^2, half of it for the missed vehicle and for the false track."""
    cars = [Body(0, 10.0, 5.0), Body(1, 10.0, -5.0)]
    tracks = [follow(cars[0], x=11.0), Estimate(7, 20.0, 25.0)]
    metrics = metrics_of([cars], [tracks])
    assert values(metrics, *PARTS) == pytest.approx([1.0, 2.0, 2.0])
    assert values(metrics, "gospa_m") == pytest.approx([5.0**0.5])


def test_a_pair_at_the_cut_off_is_a_missed_vehicle_and_a_false_track():
    car = Body(0, 10.0, 5.0)
    for offset_m, parts in ((1.99, [1.99**2, 0.0, 0.0]), (2.0, [0.0, 2.0, 2.0])):
        assert values(metrics_of([[car]], [[follow(car, x=10.0 + offset_m)]]), *PARTS) == pytest.approx(parts)


def test_the_cut_off_is_a_setting():
    car = Body(0, 10.0, 5.0)
    metrics = metrics_of([[car]], [[]], config=GradingConfig(gospa_cutoff_m=6.0))
    assert values(metrics, "gospa_m") == pytest.approx([18.0**0.5])


def test_the_mean_is_over_frames_with_a_vehicle_or_a_track():
    car = Body(0, 10.0, 5.0)
    metrics = metrics_of([[car], [car], [], []], [[follow(car)], [], [Estimate(7, 20.0, 25.0)], []])
    assert values(metrics, "gospa_m") == pytest.approx([(0.0 + 2.0**0.5 + 2.0**0.5) / 3])
    assert metrics["track.gospa_m"].n == 3


def test_bands_have_the_costs_of_their_vehicles_and_ranges_those_of_false_tracks():
    car = Body(0, 10.0, 5.0)
    bus = Body(1, 40.0, 5.0, size=(12.0, 2.5, 3.0), kind=Kind.BUS, view=View.REAR)
    metrics = metrics_of([[car, bus]], [[follow(car, x=10.5), Estimate(7, 20.0, 0.0)]])
    expected = {"range=0-15": 0.5, "range=15-30": 2**0.5, "range=30-50": 2**0.5}
    expected |= {"class=car": 0.5, "class=bus": 2**0.5, "view=l_shape": 0.5, "view=rear": 2**0.5}
    found = {band: metrics[f"track.gospa_m{{{band}}}"].value for band in expected}
    assert found == pytest.approx(expected)
    missing = metrics["track.gospa_m{class=van}"]
    assert (missing.value, missing.reason) == (None, "no vehicle was graded and no track was reported, with class van")


def least(vehicles, tracks, cutoff):
    """Squared GOSPA of one frame by exhaustive search: pairs of the shorter list with the other, or with nothing."""
    if len(vehicles) > len(tracks):
        return least(tracks, vehicles, cutoff)
    options = [*range(len(tracks)), *[None] * len(vehicles)]
    costs = []
    for chosen in set(permutations(options, len(vehicles))):
        pairs = [(v, t) for v, t in enumerate(chosen) if t is not None]
        apart = sum(float(np.sum((vehicles[v] - tracks[t]) ** 2)) for v, t in pairs)
        costs.append(apart + 0.5 * cutoff**2 * (len(vehicles) + len(tracks) - 2 * len(pairs)))
    return min(costs, default=0.0)


@given(st.integers(0, 2**32 - 1), st.lists(st.tuples(st.integers(0, 3), st.integers(0, 4)), min_size=1, max_size=3))
def test_the_assignment_is_optimal_in_every_frame(seed, counts):
    """In a square of 4 m nearly all pairs compete."""
    rng = np.random.default_rng(seed)
    frames = [(rng.uniform(0, 4, (v, 2)), rng.uniform(0, 4, (t, 2))) for v, t in counts]
    vehicles, tracks = (pd.concat([at(f[side], i) for i, f in enumerate(frames)]) for side in (0, 1))
    found = gospa.assign(vehicles, tracks, 2.0)
    total = found.squared.sum() + 2.0 * (len(vehicles) + len(tracks) - 2 * len(found.squared))
    assert total == pytest.approx(sum(least(v, t, 2.0) for v, t in frames))
    assert len(np.unique(found.vehicle)) == len(np.unique(found.track)) == len(found.squared)
    assert (vehicles["frame"].to_numpy()[found.vehicle] == tracks["frame"].to_numpy()[found.track]).all()
