"""Worst frames of every metric, with descriptions of the errors in them."""

import dataclasses

import pandas as pd
import pytest
from support import short_run
from support.many_metrics import METRICS

from luxloop.scenarios.grading.figures import Figures
from luxloop.scenarios.grading.frame_tables import FITS, OUTLIERS, OVERLAPS, SEGMENTS, TRACKS, TRUTH
from luxloop.scenarios.grading.grading_config import GradingConfig
from luxloop.scenarios.grading.observations import RunObservations
from luxloop.scenarios.grading.worst_frames import worst_frames
from luxloop.scenarios.metrics.definitions import find_metric
from luxloop.scenarios.result import Metric, Result

FIT_ERRORS = {"heading_error_deg": float, "position_error_m": float, "iou": float, "oracle": bool}


def table(schema, rows, **more):
    """Table with these rows; missing frames are 0, 1, ..., and other missing values are 0."""
    columns = {"frame": int, "time_s": float} | dict(schema) | more
    filled = [{"frame": frame, "time_s": 0.08 * row.get("frame", frame), **row} for frame, row in enumerate(rows)]
    values = {name: [row.get(name, zero(kind)) for row in filled] for name, kind in columns.items()}
    made = {name: pd.Categorical(values[name], kind) for name, kind in columns.items() if isinstance(kind, tuple)}
    return pd.DataFrame(values | made)


def zero(kind):
    return kind[0] if isinstance(kind, tuple) else kind()


def worst(metric, **tables):
    tables = {**empty(), **tables}
    figures = Figures(RunObservations(tables, GradingConfig(), 4), {metric: Metric(1.0, find_metric(metric).unit, 1)})
    result = dataclasses.replace(short_run.result(), metrics=figures, tables=tables)
    return [(found.frame, found.what) for found in worst_frames(result, metric)]


def empty():
    return {
        "truth": table(TRUTH, [{"actor_id": 7, "name": "car.7"}]),
        "tracks": table(TRACKS, []),
        "fits": table(FITS, [], **FIT_ERRORS),
        "segments": table(SEGMENTS, []),
        "outliers": table(OUTLIERS, [{}]),
        "overlaps": table(OVERLAPS, []),
    }


FIT = {"actor_id": 7, "view": "rear", "range_m": 12.0, "method": "area"}
TRACK = {"judged": True, "track_id": 3, "actor_id": 7, "true_mode": "cv", "model": "ca"}


@pytest.mark.parametrize(
    ("metric", "errors", "expected"),
    [
        (
            "fit.heading_abs_mean_deg{method=area}",
            {"heading_error_deg": [1.0, -4.0, 0.0]},
            [(1, "heading error -4 deg"), (0, "heading error 1 deg")],
        ),
        (
            "fit.within_1deg{method=area,view=rear}",
            {"heading_error_deg": [1.0, -4.0, 0.0]},
            [(1, "heading error -4 deg")],
        ),
        ("fit.within_1deg{method=area,view=side}", {"heading_error_deg": [1.0, -4.0, 0.0]}, []),
        ("fit.heading_mean_deg{method=variance}", {"heading_error_deg": [1.0, -4.0, 0.0]}, []),
        (
            "fit.position_abs_mean_m{method=area}",
            {"position_error_m": [0.1, 0.0, 0.5]},
            [(2, "position error 0.5 m"), (0, "position error 0.1 m")],
        ),
        ("fit.iou_mean{method=area}", {"iou": [0.9, 1.0, 0.25]}, [(2, "iou 0.25"), (0, "iou 0.9")]),
    ],
)
def test_fits(metric, errors, expected):
    """Fails when another view, method or error is described."""
    rows = [{**FIT, **{name: values[i] for name, values in errors.items()}} for i in range(3)]
    found = worst(metric, fits=table(FITS, rows, **FIT_ERRORS))
    assert [frame for frame, _ in found] == [frame for frame, _ in expected]
    for (_, what), (_, words) in zip(found, expected, strict=True):
        assert what.startswith("the area rectangle on vehicle car.7 (rear, 12 m)")
        assert words in what


def test_coverage_is_worst_at_observations_without_a_rectangle():
    seen = {"graded": True, "actor_id": 7, "name": "car.7", "points": 20, "range_m": 12.0, "largest_segment_share": 1.0}
    fitted = [{**FIT, "best": True, "heading_error_deg": 5.0}]
    found = worst("fit.coverage", truth=table(TRUTH, [seen, seen]), fits=table(FITS, fitted, **FIT_ERRORS))
    assert found == [(1, "vehicle car.7 (20 points, 12 m)")]


@pytest.mark.parametrize(
    ("metric", "rows", "frames", "words"),
    [
        (
            "mma.x_abs_mean_m{model=cv,target=moving}",
            [{"cv_x_error_m": -2.0}, {"cv_y_error_m": 9.0}],
            [0],
            ": cv x error -2 m",
        ),
        (
            "mma.y_abs_std_m{target=moving}",
            [{"cv_y_error_m": 2.0}, {"mma_y_error_m": 1.0}],
            [1],
            ": mma y error 1 m",
        ),
        ("mma.x_abs_mean_m{model=cv,target=standing}", [{"cv_x_error_m": -2.0}], [], ""),
        ("mma.gain{target=moving}", [{"mma_x_error_m": 3.0, "mma_y_error_m": 4.0}], [0], ": mma x error 3 m"),
        ("mma.mode_accuracy", [{"model": "cv"}, {}], [1], " (ca, truly cv)"),
        ("mma.selected{mode=cv,model=ca}", [{"model": "cv"}, {}], [], ""),  # neither more nor less is better
        ("mma.stationary_accuracy", [{}, {"model": "stationary"}], [1], " (stationary, truly cv)"),
        ("mma.nees_in_band", [{"nees": 2.0}, {"nees": 20.0}, {"nees": 0.02}], [1, 2], ": mma nees mean 20"),
        (
            "mma.nis_mean{model=ca}",
            [{"ca_nis": 99.0}, {"ca_nis": 20.0, "cv_nis": 2.0, "true_mode": "ca"}],
            [1],
            ": ca nis mean 20",
        ),
        ("track.heading_abs_mean_deg", [{"heading_error_deg": -170.0}], [0], ": heading error -170 deg"),
        ("track.heading_flip_rate", [{"heading_error_deg": 9.0, "true_mode": "stationary"}], [], ""),
    ],
)
def test_tracks(metric, rows, frames, words):
    tracks = table(TRACKS, [{**TRACK, "nees": 2.0, "ca_nis": 2.0, "iou": 1.0, **row} for row in rows])
    found = worst(metric, tracks=tracks)
    assert [frame for frame, _ in found] == frames
    assert all(what.startswith("track 3 on vehicle car.7") for _, what in found)
    assert words in "".join(what for _, what in found)
    assert not worst(metric, tracks=tracks.assign(judged=False))


def test_segments():
    seen = {"graded": True, "actor_id": 7, "name": "car.7", "points": 20, "range_m": 12.0}
    split = {**seen, "largest_segment_share": 0.4, "segments": 2}
    truth = table(TRUTH, [split, {**seen, "largest_segment_share": 1.0}])
    segments = table(SEGMENTS, [{}, {"segment": 5, "points": 40, "second_share": 0.3}])
    expected = "vehicle car.7 (20 points, 12 m): outside largest segment share 0.6"
    assert worst("segmentation.over_rate", truth=truth, segments=segments) == [(0, expected)]
    assert worst("segmentation.missed_rate", truth=truth, segments=segments) == [(0, expected)]
    expected = "segment 5 (40 points): second share 0.3"
    assert worst("segmentation.under_rate", truth=truth, segments=segments) == [(1, expected)]


def test_outliers():
    rows = [{"cause": "mirror", "points": 4, "removed": 3, "clean_removed_beside": 1}, {"cause": "ghost", "points": 9}]
    expected = [(0, "3 of 4 points of cause mirror removed, and 1 clean points with them")]
    assert worst("outliers.recall{cause=mirror}", outliers=table(OUTLIERS, rows)) == expected


def test_control():
    rows = [
        {"driver": "tracks", "ttc_s": 4.0, "gap_m": 2.0, "acceleration_mps2": 1.0, "collides": False},
        {"driver": "tracks", "ttc_s": 2.0, "gap_m": 9.0, "acceleration_mps2": -3.0, "collides": True},
        {"driver": "truth", "ttc_s": 0.5, "gap_m": 0.5, "acceleration_mps2": -9.0, "collides": True},
    ]
    control = table({name: type(value) for name, value in rows[0].items()}, rows)
    near, far = "4.00 s to a collision, 2.0 m away", "2.00 s to a collision, 9.0 m away"
    assert worst("control.min_ttc_s", control=control) == [(1, far), (0, near)]
    assert worst("control.min_gap_m", control=control) == [(0, near), (1, far)]
    assert worst("control.max_deceleration_mps2", control=control) == [(1, "it brakes at 3.0 m/s^2")]
    assert worst("control.truth_max_deceleration_mps2", control=control) == [(2, "it brakes at 9.0 m/s^2")]
    assert worst("control.collisions", control=control) == [(1, "the ego collides")]


def test_identities():
    seen = {"graded": True, "actor_id": 7, "name": "car.7"}
    rows = [{**seen, "track_id": 3}, {**seen, "track_id": -1}, {**seen, "track_id": 5}, {**seen, "track_id": 5}]
    truth = table(TRUTH, rows)
    for metric in ("track.id_switches", "track.occlusion_survival", "track.hidden_2s_survival", "track.fragments"):
        assert worst(metric, truth=truth) == [(2, "vehicle car.7 goes from track 3 to track 5")]


def test_frames_are_unique_and_limited_in_number():
    rows = [
        {**FIT, "frame": frame, "heading_error_deg": error} for frame, error in [(0, 1), (0, 9), (1, 2), (2, 3), (3, 4)]
    ]
    found = worst("fit.heading_std_deg{method=area}", fits=table(FITS, rows, **FIT_ERRORS))
    assert [frame for frame, _ in found] == [0, 3, 2]


SHOWN = ("fit.heading_abs_mean_deg", "perf.sim_ms_p50", "mma.switch_latency_frames", "track.hota")


@pytest.mark.parametrize("metrics", [{*METRICS[::7], *SHOWN}, pytest.param(METRICS, marks=pytest.mark.slow)])
def test_every_metric_of_a_real_run_has_valid_worst_frames(metrics):
    """Worst frames of any metric are frames of the run, or an empty list."""
    result: Result = short_run.result()
    frames = {metric: worst_frames(result, metric) for metric in metrics}
    assert {worst.frame for found in frames.values() for worst in found} <= set(range(short_run.FRAMES))
    assert frames["fit.heading_abs_mean_deg"]
    assert not frames["perf.sim_ms_p50"]
    assert not frames["mma.switch_latency_frames"]  # it has no value
    assert str(frames["track.hota"][0]).startswith("frame ")
