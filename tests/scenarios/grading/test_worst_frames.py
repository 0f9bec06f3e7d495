"""Worst frames of every metric, with descriptions of the errors in them."""

import dataclasses

import pandas as pd
import pytest
from support import short_run
from support.many_metrics import METRICS

from luxloop.scenarios.grading.frame_tables import FITS, OUTLIERS, SEGMENTS, TRACKS, TRUTH
from luxloop.scenarios.grading.worst_frames import worst_frames
from luxloop.scenarios.metrics.definitions import find_metric
from luxloop.scenarios.result import Metric, Result

FIT_ERRORS = {"heading_error_deg": float, "position_error_m": float, "iou": float, "oracle": bool}


def table(schema, rows, **more):
    """Table with these rows; missing frames are 0, 1, ..., and other missing values are 0."""
    columns = {"frame": int, "time_s": float} | dict(schema) | more
    filled = [{"frame": frame, "time_s": 0.08 * row.get("frame", frame), **row} for frame, row in enumerate(rows)]
    return pd.DataFrame({name: [row.get(name, zero(kind)) for row in filled] for name, kind in columns.items()})


def zero(kind):
    return kind[0] if isinstance(kind, tuple) else kind()


def worst(metric, **tables):
    result = dataclasses.replace(
        short_run.result(), metrics={metric: Metric(1.0, find_metric(metric).unit, 1)}, tables={**empty(), **tables}
    )
    return [(found.frame, found.what) for found in worst_frames(result, metric)]


def empty():
    return {
        "truth": table(TRUTH, [{"actor_id": 7, "name": "car.7"}]),
        "tracks": table(TRACKS, []),
        "fits": table(FITS, [], **FIT_ERRORS),
        "segments": table(SEGMENTS, []),
        "outliers": table(OUTLIERS, []),
    }


FIT = {"actor_id": 7, "view": "rear", "range_m": 12.0, "method": "area"}
TRACK = {"judged": True, "track_id": 3, "actor_id": 7, "true_mode": "cv", "model": "ca"}


@pytest.mark.parametrize(
    ("metric", "errors", "expected"),
    [
        (
            "fit.heading_abs_mean_deg{method=area}",
            {"heading_error_deg": [1.0, -4.0, 0.0]},
            [(1, "-4.0 deg off"), (0, "+1.0")],
        ),
        (
            "fit.within_1deg{method=area,view=rear}",
            {"heading_error_deg": [1.0, -4.0, 0.0]},
            [(1, "-4.0 deg off"), (0, "+1.0")],
        ),
        ("fit.within_1deg{method=area,view=side}", {"heading_error_deg": [1.0, -4.0, 0.0]}, []),
        ("fit.heading_mean_deg{method=variance}", {"heading_error_deg": [1.0, -4.0, 0.0]}, []),
        (
            "fit.position_abs_mean_m{method=area}",
            {"position_error_m": [0.1, 0.0, 0.5]},
            [(2, "0.50 m off"), (0, "0.10 m")],
        ),
        ("fit.iou_mean{method=area}", {"iou": [0.9, 1.0, 0.25]}, [(2, "overlaps it by 0.25"), (0, "by 0.90")]),
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
    rows = [{**FIT, "best": True, "heading_error_deg": error} for error in (5.0, float("nan"))]
    found = worst("fit.coverage", fits=table(FITS, rows, **FIT_ERRORS))
    assert found == [(1, "no rectangle on vehicle car.7 (rear, 12 m)")]


@pytest.mark.parametrize(
    ("metric", "rows", "frames", "words"),
    [
        (
            "mma.x_abs_mean_m{model=cv,target=moving}",
            [{"cv_x_error_m": -2.0}, {"cv_y_error_m": 9.0}],
            [0],
            "2.00 m off by cv",
        ),
        (
            "mma.y_abs_std_m{target=moving}",
            [{"cv_y_error_m": 2.0}, {"mma_y_error_m": 1.0}],
            [1],
            "1.00 m off by mma",
        ),
        ("mma.x_abs_mean_m{model=cv,target=standing}", [{"cv_x_error_m": -2.0}], [], ""),
        ("mma.gain{target=moving}", [{"mma_x_error_m": 3.0, "mma_y_error_m": 4.0}], [0], "5.00 m off by mma"),
        ("mma.mode_accuracy", [{"model": "cv"}, {}], [1], "is ca, truly cv"),
        ("mma.selected{mode=cv,model=ca}", [{"model": "cv"}, {}], [1], "is ca, truly cv"),
        ("mma.stationary_accuracy", [{}, {"model": "stationary"}], [1], "is stationary, truly cv"),
        ("mma.nees_in_band", [{"nees": 2.0}, {"nees": 20.0}, {"nees": 0.02}], [2, 1], "a nees of 0.02, expected 2"),
        (
            "mma.nis_mean{model=ca}",
            [{"ca_nis": 2.0, "cv_nis": 99.0}, {"ca_nis": 20.0, "cv_nis": 2.0}],
            [1],
            "ca nis of 20",
        ),
        ("track.heading_abs_mean_deg", [{"heading_error_deg": -170.0}], [0], "is -170.0 deg off in its track heading"),
        ("track.heading_flip_rate", [{"heading_error_deg": 9.0, "true_mode": "stationary"}], [], ""),
        ("track.loca", [{"iou": 0.8}, {"iou": 0.5}], [1, 0], "overlaps it by 0.50"),
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
    truth = table(
        TRUTH, [{"graded": True, "actor_id": 7, "name": "car.7", "points": 20, "largest_segment_share": 0.4}, {}]
    )
    segments = table(SEGMENTS, [{}, {"segment": 5, "points": 40, "second_share": 0.3}])
    expected = "40% of the 20 points of vehicle car.7 are in its largest segment"
    assert worst("segmentation.over_rate", truth=truth, segments=segments) == [(0, expected)]
    assert worst("segmentation.missed_rate", truth=truth, segments=segments) == [(0, expected)]
    expected = "30% of the 40 points of segment 5 belong to another object"
    assert worst("segmentation.under_rate", truth=truth, segments=segments) == [(1, expected)]


def test_outliers():
    rows = [{"cause": "mirror", "points": 4, "removed": 3, "clean_removed_beside": 1}, {"cause": "ghost", "points": 9}]
    expected = [(0, "3 of 4 removed, and 1 clean points with them")]
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


def test_identities_and_detections():
    seen = {"graded": True, "actor_id": 7, "name": "car.7"}
    rows = [{**seen, "track_id": 3}, {**seen, "track_id": -1}, {**seen, "track_id": 5}, {**seen, "track_id": 5}]
    truth, tracks = (
        table(TRUTH, rows),
        table(TRACKS, [{"frame": 1, "verdict": "false"}, {"frame": 3, "verdict": "false"}]),
    )
    for metric in ("track.id_switches", "track.occlusion_survival", "track.hidden_2s_survival", "track.fragments"):
        assert worst(metric, truth=truth, tracks=tracks) == [(2, "vehicle car.7 goes from track 3 to track 5")]
    missed, false = (f"{n} graded vehicles without a track, 1 false tracks" for n in (1, 0))
    assert worst("track.hota", truth=truth, tracks=tracks) == [(1, missed), (3, false)]


def test_frames_are_unique_and_limited_in_number():
    rows = [
        {**FIT, "frame": frame, "heading_error_deg": error} for frame, error in [(0, 1), (0, 9), (1, 2), (2, 3), (3, 4)]
    ]
    found = worst("fit.heading_std_deg{method=area}", fits=table(FITS, rows, **FIT_ERRORS))
    assert [frame for frame, _ in found] == [0, 3, 2]


def test_every_metric_of_a_real_run_has_valid_worst_frames():
    """Worst frames of any metric are frames of the run, or an empty list."""
    result: Result = short_run.result()
    frames = {metric: worst_frames(result, metric) for metric in METRICS}
    assert {worst.frame for found in frames.values() for worst in found} <= set(range(short_run.FRAMES))
    assert frames["fit.heading_abs_mean_deg"]
    assert not frames["perf.sim_ms_p50"]
    assert not frames["mma.switch_latency_frames"]  # it has no value
    assert str(frames["track.hota"][0]).startswith("frame ")
