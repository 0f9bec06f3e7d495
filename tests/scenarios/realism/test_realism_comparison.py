"""Matching by view, averages with intervals, and verdicts."""

import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st
from support.labelled_shapes import rear, vehicle

from luxloop.scenarios.errors import InputError
from luxloop.scenarios.realism import realism_comparison
from luxloop.scenarios.realism.real_table import BANDS
from luxloop.scenarios.realism.realism_comparison import FIGURES, ComparedRow, Summary, summarise

BY_NAME = {figure.name: figure for figure in FIGURES}
VIEWS = st.lists(st.tuples(st.floats(4.0, 50.0), st.floats(0.0, 90.0), st.booleans()), min_size=1, max_size=12)


def views(rows):
    return pd.DataFrame(rows, columns=["range_m", "aspect_deg", "front_seen"])


@given(VIEWS, VIEWS)
def test_matches_are_the_three_nearest_of_the_same_end(real, simulated):
    """Against an exhaustive search; ties may be broken either way, so distances are compared."""
    real_row, row, distance = realism_comparison.match(views(real), views(simulated))
    for number, (range_m, aspect, front) in enumerate(real):
        gaps = sorted(
            np.hypot(np.log(range_m / other[0]) / 0.15, (aspect - other[1]) / 8.0)
            for other in simulated
            if other[2] == front
        )[:3]
        np.testing.assert_allclose(np.sort(distance[real_row == number]), gaps, atol=1e-9)
        assert all(simulated[n][2] == front for n in row[real_row == number])
        assert len(set(row[real_row == number])) == len(gaps)


def test_summary_by_hand():
    found = summarise(np.array([1.0, 9.0, np.nan, 2.0, 4.0]), np.arange(5), "median")
    assert (found.value, found.n) == (3.0, 4)
    assert found.quartiles == (1.75, 5.25)
    assert summarise(np.array([1.0, 9.0, 2.0, 4.0]), np.arange(4), "mean").value == 4.0
    assert summarise(np.array([np.nan]), np.array([0]), "median") is None
    assert summarise(np.array([1.0, 2.0]), np.array([7, 7]), "median").interval is None


def test_intervals_are_over_vehicles():
    """Ten times as many observations that repeat those of each vehicle change nothing."""
    rng = np.random.default_rng(1)
    values, actor = rng.normal(size=40), np.sort(rng.integers(9, size=40))
    once, often = (summarise(np.repeat(values, k), np.repeat(actor, k), "mean").interval for k in (1, 10))
    assert once == pytest.approx(often)
    low, high = summarise(values, actor, "median").interval
    assert low < np.median(values) < high


@pytest.mark.parametrize(
    ("name", "simulated", "verdict"),
    [
        ("bow_end_m", 0.121, "agrees"),  # real 0.16, quartiles 0.15 to 0.30: within 25 %
        ("bow_end_m", 0.119, "differs"),
        ("bow_end_m", 0.29, "agrees"),  # inside the quartiles
        ("bow_end_m", 0.31, "differs"),
        ("best_error_deg", 0.235, "agrees"),  # within 50 %
        ("best_error_deg", 0.245, "differs"),  # quartiles do not count
        ("best_error_deg", 0.085, "agrees"),
        ("best_error_deg", 0.075, "differs"),
    ],
)
def test_verdict(name, simulated, verdict):
    real = Summary(0.16, None, (0.15, 0.30), 12)
    assert ComparedRow(BY_NAME[name], real, Summary(simulated, None, (0.0, 1.0), 9)).verdict == verdict


def test_a_figure_without_values_has_no_verdict():
    assert ComparedRow(BY_NAME["bow_end_m"], Summary(0.16, None, (0.1, 0.2), 12), None).verdict == "n/a"


def bowed(bow, height, actor, range_m=20.0):
    """A rear of one scan line, seen from behind."""
    along = np.linspace(-0.75, 0.75, 21)
    points = rear(bow * (along / 0.75) ** 2, along)
    return vehicle(points, height=height, lidars=[(-range_m, 0.0)], actor_id=actor)


def test_figures_of_matched_vehicles_stand_beside_the_real_ones():
    """Three cars at 20 m match; those at 40 m, flat, are further away and do not count."""
    seen = [bowed(bow, 0.6, n) for n, bow in enumerate([0.1, 0.2, 0.15])] + [bowed(0.0, 0.6, 9, 40.0)] * 3
    real = views([(20.0, 0.0, False)] * 2).assign(bow_end_m=[0.17, 0.21])
    bands = pd.DataFrame([("end", 0.45, 0.75, 0.12, 0.16, 0.28, 12.0)], columns=list(BANDS))
    found = realism_comparison.compare(real, bands, seen)
    band, bow = found.rows
    assert (found.observations, len(found.vehicles), found.far) == (6, 3, 0)
    assert band.figure.label == "bow end 0.45 to 0.75 m"
    assert (band.real.value, band.real.quartiles, band.real.n) == (0.16, (0.12, 0.28), 12)
    assert band.simulated.value == pytest.approx(0.05)  # of all six: 0, 0, 0, 10, 15 and 20 cm
    assert bow.real.value == pytest.approx(0.19)
    assert (bow.simulated.value, bow.simulated.n) == (pytest.approx(0.15), 6)
    assert [row.verdict for row in found.rows] == ["differs", "agrees"]


def test_bow_in_a_band_is_that_of_the_lines_at_its_height():
    """A line at the upper limit is in the next band; vehicle 2 has its median of two lines in the first."""
    limits, real = [("end", 0.0, 0.45), ("end", 0.45, 0.75), ("flank", 0.0, 1.0)], (0.1, 0.2, 0.3, 4.0)
    bands = pd.DataFrame([(*limit, *real) for limit in limits], columns=list(BANDS))
    along = np.linspace(-0.75, 0.75, 21)
    double = np.concatenate([rear(bow * (along / 0.75) ** 2, along) for bow in (0.08, 0.10)])
    two_lines = vehicle(double, line=np.repeat([0, 1], 21), height=np.repeat([0.2, 0.3], 21), actor_id=2)
    low, high, flank = realism_comparison.compare_bow(bands, [bowed(0.2, 0.45, 1), two_lines, bowed(0.05, 0.44, 3)])
    assert (low.simulated.value, low.simulated.n) == (pytest.approx(np.median([0.09, 0.05])), 2)
    assert (high.simulated.value, high.simulated.n) == (pytest.approx(0.20), 1)
    assert flank.simulated is None


def test_many_observations_are_thinned(monkeypatch):
    monkeypatch.setattr(realism_comparison, "OBSERVATIONS_MAX", 4)
    bands = pd.DataFrame([("end", 0.0, 1.0, 0.1, 0.2, 0.3, 4.0)], columns=list(BANDS))
    vehicles = [bowed(0.1, 0.6, n) for n in range(9)]
    (row,) = realism_comparison.compare_bow(bands, vehicles)
    assert row.simulated.n == 4
    # Two vehicles in each of eight frames: a whole step would take one of them only.
    kept = realism_comparison.thinned([vehicles[n % 2] for n in range(16)])
    assert {one.actor_id for one in kept} == {0, 1}


def test_real_vehicles_without_a_near_simulated_one_are_counted():
    real = views([(20.0, 0.0, False), (20.0, 30.0, False), (20.0, 0.0, True)]).assign(bow_end_m=0.1)
    bands = pd.DataFrame(columns=pd.Index(BANDS))
    assert realism_comparison.compare(real, bands, [bowed(0.1, 0.6, 1)]).far == 2


def test_nothing_to_compare():
    bands, front = pd.DataFrame(columns=pd.Index(BANDS)), views([(20.0, 0.0, True)]).assign(bow_end_m=0.1)
    with pytest.raises(InputError, match="no graded vehicle"):
        realism_comparison.compare(front, bands, [])
    with pytest.raises(InputError, match="no simulated vehicle shows the end"):
        realism_comparison.compare(front, bands, [bowed(0.1, 0.6, 1)])
