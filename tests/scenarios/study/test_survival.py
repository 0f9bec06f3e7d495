"""Survival statistics of a study, with the published example, clusters of seeds, figures and tables."""

import math

import numpy as np
import pandas as pd
import pytest
import scipy
from support.remission import PLACEBO, REACHED, TREATED

from luxloop.scenarios.errors import StudyError
from luxloop.scenarios.study import survival
from luxloop.scenarios.study.study_file import Study
from luxloop.scenarios.study.study_page import survival_lines
from luxloop.scenarios.study.survival import survival_picture


def samples(time, reached, seed=None):
    return pd.DataFrame({"time": time, "reached": reached, "seed": np.arange(len(time)) if seed is None else seed})


def test_the_log_rank_test_equals_the_published_one():
    treated, placebo = samples(TREATED, REACHED), samples(PLACEBO, np.ones(21, np.bool_))
    p = survival.log_rank(treated, placebo)
    assert scipy.stats.chi2.isf(p, 1) == pytest.approx(16.79, abs=0.005)
    assert survival.log_rank(placebo, treated) == pytest.approx(p)


def test_the_curve_is_the_published_one_and_its_variance_greenwood_s():
    found = survival.curve(TREATED, REACHED, np.arange(21))
    ours = dict(zip(found.at.tolist(), found.share.tolist(), strict=True))
    assert (ours[6], ours[10], ours[23]) == pytest.approx((0.857, 0.753, 0.448), abs=0.0006)
    # Greenwood by hand at week 10: 3/(21*18) + 1/(17*16) + 1/(15*14), and Clopper and Pearson with that many runs.
    variance = 0.7529**2 * (3 / (21 * 18) + 1 / (17 * 16) + 1 / (15 * 14))
    number = min(0.7529 * (1 - 0.7529) / (variance * 21 / 20), 21)
    expected = scipy.stats.beta.ppf(0.025, 0.7529 * number, 0.2471 * number + 1)
    assert found.low[found.at == 10] == pytest.approx(expected, abs=0.004)


def test_without_censoring_the_interval_is_the_binomial_one():
    found = survival.curve(np.arange(1.0, 9.0), np.ones(8, np.bool_), np.arange(8))
    assert found.share == pytest.approx(1.0 - np.arange(1, 9) / 8)
    # The variance between 8 seeds, divided by 7, is that of 7 independent runs.
    for k in range(7):
        count = 7 * (7 - k) / 8
        exact = scipy.stats.beta.ppf(0.025, count, 8 - count), scipy.stats.beta.ppf(0.975, count + 1, 7 - count)
        assert (found.low[k], found.high[k]) == pytest.approx(exact)
    assert found.start == pytest.approx((0.025 ** (1 / 8), 1.0))
    assert (found.low[-1], found.share[-1]) == (0.0, 0.0)


def test_runs_of_one_seed_count_as_one_if_they_agree():
    time, seed = np.arange(1.0, 7.0), np.arange(6)
    once = survival.curve(time, np.ones(6, np.bool_), seed)
    four = survival.curve(np.repeat(time, 4), np.ones(24, np.bool_), np.repeat(seed, 4))
    independent = survival.curve(np.repeat(time, 4), np.ones(24, np.bool_), np.arange(24))
    width = [np.mean(one.high[:-1] - one.low[:-1]) for one in (once, four, independent)]
    assert width[1] > 0.85 * width[0]
    assert width[2] < 0.6 * width[0]


@pytest.mark.parametrize(("seeds", "runs"), [(5, 1), (8, 2)])
def test_intervals_hold_the_truth_as_often_as_they_say(seeds, runs):
    draw, hits, share = np.random.default_rng(seeds), 0, math.exp(-0.7)
    for _ in range(300):
        common = draw.exponential(size=seeds)
        own = np.where(draw.random((runs, seeds)) < 0.5, common, draw.exponential(size=(runs, seeds)))  # exponential
        limit = draw.uniform(0.5, 3.0, (runs, seeds))
        time, reached = np.minimum(own, limit).ravel(), (own <= limit).ravel()
        if not reached.any():
            hits += 1
            continue
        found = survival.curve(time, reached, np.tile(np.arange(seeds), runs))
        k = np.searchsorted(found.at, 0.7, side="right") - 1
        low, high = (found.low[k], found.high[k]) if k >= 0 else found.start
        hits += low <= share <= high
    assert hits >= 0.93 * 300


def test_medians_and_tests_without_events():
    never = survival.curve(np.ones(4), np.zeros(4, np.bool_), np.arange(4))
    assert survival.median(never) == (math.inf, math.inf, math.inf)
    frame = samples(np.ones(4), np.zeros(4, np.bool_))
    assert math.isnan(survival.log_rank(frame, frame))


STUDY = """
description = "A study."
scenario = "ring"
[[vary]]
key = "ego_mps"
label = "speed"
values = [8.0, 14.0]
[[curve]]
metric = "emergence.meeting_m{stage=confirmed}"
kind = "survival"
by = "ego_mps"
"""


@pytest.fixture
def study(tmp_path):
    path = tmp_path / "study.toml"
    path.write_text(STUDY)
    return Study.load(path)


def rows(reached=(1, 1, 0, 1, 1, 1), meeting=(9.0, 6.0, None, 3.0, 2.5, 2.0)):
    return pd.DataFrame(
        {
            "seed": [1, 2, 3] * 2,
            "ego_mps": [8.0] * 3 + [14.0] * 3,
            "emergence.reached{stage=confirmed}": np.array(reached, float),
            "emergence.meeting_m{stage=confirmed}": np.array(meeting, float),
            "emergence.meeting_m{stage=end}": np.array([None, None, 0.5, None, None, None], float),
        }
    )


def test_a_run_that_never_reaches_the_stage_is_in_the_samples():
    found = survival.samples(rows(), "emergence.meeting_m{stage=confirmed}", ["ego_mps"])
    assert found["time"].tolist() == [-9.0, -6.0, -0.5, -3.0, -2.5, -2.0]
    assert found["reached"].tolist() == [True, True, False, True, True, True]


def test_the_table_has_runs_medians_and_tests(study):
    head, (slow, fast) = survival_lines(study, rows(), study.curve[0])
    assert head == ["speed", "runs", "reached", "median", "95 %", "log-rank p against the first"]
    assert slow[:4] == ["8", "3", "2", "6"]
    assert fast[:4] == ["14", "3", "3", "2.5"]
    found = survival.samples(rows(), study.curve[0].metric, ["ego_mps"])
    found = survival.samples(rows(), study.curve[0].metric, ["ego_mps"])
    assert float(fast[-1]) == pytest.approx(survival.log_rank(found.head(3), found.tail(3)), abs=0.0006)


@pytest.mark.parametrize("table", [rows(), rows((0,) * 6, (None,) * 6).head(3)])
def test_the_figure_is_drawn_also_if_hardly_any_run_has_a_value(study, table, tmp_path):
    picture = survival_picture(study, table, study.curve[0], "figure")
    assert "share of runs with a confirmed track" in picture.svg or len(table) < 6
    (written,) = picture.save(tmp_path, ["png"])
    assert written.stat().st_size > 5000
    assert ("2 runs without a value" in picture.caption) == (len(table) < 6)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ('metric = "emergence.range_m{stage=confirmed}"', "has no survival curve; name one like"),
        ('metric = "track.hota"', "has no survival curve"),
        (
            'metric = "emergence.time_s{stage=located}"\nagainst = "ego_mps"',
            "leave it out, the axis of a survival curve is its",
        ),
        ('metric = "emergence.time_s{stage=located}"\nkind = "curve"', "a curve needs against"),
    ],
)
def test_invalid_curves_are_one_line(change, message, tmp_path):
    body = change if "kind" in change else f'{change}\nkind = "survival"'
    path = tmp_path / "study.toml"
    path.write_text(STUDY.partition("[[curve]]")[0] + "[[curve]]\n" + body)
    with pytest.raises(StudyError, match=message) as raised:
        Study.load(path)
    assert "\n" not in str(raised.value)
