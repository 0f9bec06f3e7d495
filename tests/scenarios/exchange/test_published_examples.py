"""Metrics of files on published examples: HOTA's figure 1, py-motmetrics' README, nuScenes' own tests, GOSPA."""

import json

import numpy as np
import pytest
from support import box_files, devkit_averages
from support.box_files import Box

from luxloop.scenarios.cli import main
from luxloop.scenarios.grading.distance_matching import (
    RECALLS,
    WORST_MOTP_M,
    DistanceStep,
    average,
    count,
    match_frames,
    recall_curve,
)
from luxloop.scenarios.grading.tracking_scores import TrackingScores, VehicleScores

FIGURE_1 = {
    "A": (range(50), 0.50, 0.50, 0.50, 0.50, 0.67),
    "B": (range(70), 0.70, 0.35, 0.50, 0.69, 70 / 170),
    "C": (range(100), 1.00, 0.25, 0.50, 0.97, 0.25),
}
"""Frames of 100 with a track, and DetA, AssA, HOTA, MOTA and IDF1 of figure 1 of Luiten et al. 2021, HOTA, in percent.
Its IDF1 of B, 52, is 35 / (0.5 (100 + 35)), without the second track; the formula of IDF1 (Ristani et al. 2016) gives
2 * 35 / (100 + 70)."""
PARTS = {"A": 50, "B": 35, "C": 25}
"""Frames of one track; the next 35 or 25 frames have another id."""


def graded(folder, truth, tracks, capsys, *options):
    """Metrics of the command line, by name."""
    paths = [
        box_files.write(folder, f"{name}.csv", box_files.csv(boxes)) for name, boxes in (("a", truth), ("b", tracks))
    ]
    assert main(["grade", "--truth", str(paths[0]), "--tracks", str(paths[1]), "--json", *options]) == 0
    return json.loads(capsys.readouterr().out)["metrics"]


@pytest.mark.parametrize("tracker", FIGURE_1)
def test_figure_1_of_hota(tracker, tmp_path, capsys):
    frames, *expected = FIGURE_1[tracker]
    truth = [Box(k, "t", 5.0 * k, 0.0, 0.0, 4.0, 2.0) for k in range(100)]
    tracks = [truth[k]._replace(id=f"{k // PARTS[tracker]}") for k in frames]
    metrics = graded(tmp_path, truth, tracks, capsys)
    names = ("deta", "assa", "hota", "mota", "idf1")
    found = [metrics[f"track.{name}"]["value"] for name in names]
    assert found == pytest.approx(expected, abs=0.0051)
    assert metrics["track.hota"]["value"] == pytest.approx(np.sqrt(found[0] * found[1]), abs=1e-12)


README = [
    ([0, 1], [1, 2, 3], [[0.1, np.nan, 0.3], [0.5, 0.2, 0.3]]),
    ([0, 1], [1], [[0.2], [0.4]]),
    ([0, 1], [1, 3], [[0.6, 0.2], [0.1, 0.6]]),
]
"""Objects, hypotheses and distances of the three frames in the README of py-motmetrics 1.4."""


def test_the_example_of_py_motmetrics():
    """Its README prints MOTA 0.5 and MOTP 0.34 (one match less each: a false track, a miss, a switch)."""
    steps = [DistanceStep(np.array(t), np.array(k), np.array(d)) for t, k, d in README]
    matches = list(match_frames(steps, np.inf))
    counts = count(steps, matches)
    assert (counts.false, counts.misses, counts.switches, counts.matches) == (1, 1, 1, 4)
    assert counts.mota == pytest.approx(0.5, abs=1e-12)
    assert counts.motp_m == pytest.approx(0.34, abs=1e-12)
    assert [match.switched.tolist() for match in matches] == [[False, False], [False, False], [False, True]]


def test_the_identity_score_of_the_example_of_py_motmetrics():
    """Its README prints IDF1 83.3 %. Distances up to 1 are overlaps of at least 0.5 here."""
    overlaps = [np.nan_to_num(1.0 - 0.5 * np.array(d)) for _, _, d in README]
    sequence = {
        "num_timesteps": 3, "num_gt_ids": 2, "num_tracker_ids": 4, "num_gt_dets": 6, "num_tracker_dets": 6,
        "gt_ids": [np.array(t) for t, _, _ in README], "tracker_ids": [np.array(k) for _, k, _ in README],
        "similarity_scores": overlaps,
    }  # fmt: skip
    scores = TrackingScores.of(VehicleScores.of(sequence, 0.5))
    assert scores.idf1 == pytest.approx(5 / 6, abs=1e-12)
    assert scores.mota == pytest.approx(0.5, abs=1e-12)


def test_gospa_of_points_on_a_line(tmp_path, capsys):
    """sqrt(1 + 4 + 100 / 2 (1 missed + 2 false)) = sqrt(155), Rahmathullah et al. 2017, proposition 1."""
    truth, tracks = (
        [Box(0, f"{x}", float(x), 0.0, 0.0, 1.0, 1.0) for x in places] for places in ((0, 20, 40), (1, 22, 100, 200))
    )
    metrics = graded(tmp_path, truth, tracks, capsys, "--gospa-cutoff", "10")
    assert metrics["track.gospa_m"]["value"] == pytest.approx(12.4499, abs=5e-5)
    parts = [metrics[f"track.gospa_{part}_m2"]["value"] for part in ("localisation", "missed", "false")]
    assert parts == pytest.approx([5.0, 50.0, 100.0], abs=1e-12)


def one_car(tracks, objects=range(4)):
    """Frames 0 to 3 of `test_algo.py` of nuScenes' development kit: one car at the origin, tracks by frame."""
    steps = []
    for frame in range(4):
        here = np.array([0] * (frame in objects), np.int64)
        ids = np.array(tracks.get(frame, []), np.int64)
        steps.append(DistanceStep(here, ids, np.zeros((len(here), len(ids)))))
    return steps


def curve(steps):
    return recall_curve(steps, [np.full(len(step.track_id), 0.5) for step in steps], 2.0)


def counted(points, recall):
    """tp, fp, fn, frag and ids of the recalls up to `recall`; higher ones are not reached."""
    assert all((point.counts is None) == (point.recall > recall) for point in points)
    (found,) = {point.counts for point in points if point.counts is not None}
    return found.matches, found.false, found.misses, found.fragments, found.switches


@pytest.mark.parametrize(
    ("tracks", "objects", "recall", "expected"),
    [
        pytest.param({0: [5], 1: [5], 2: [5], 3: [5]}, range(4), 1.0, (4, 0, 0, 0, 0), id="gt-submission"),
        pytest.param({0: [5], 2: [5], 3: [5]}, range(4), 0.75, (3, 0, 1, 1, 0), id="drop-prediction"),
        pytest.param({3: [5]}, range(4), 0.25, (1, 0, 3, 0, 0), id="drop-prediction-multiple"),
        pytest.param({0: [5], 1: [5], 2: [6], 3: [5]}, range(4), 0.5, (2, 0, 0, 0, 2), id="identity-switch"),
        pytest.param({0: [5], 1: [5], 2: [5], 3: [5]}, (0, 2, 3), 1.0, (3, 1, 0, 0, 0), id="drop-gt"),
    ],
)
def test_the_tests_of_nuscenes(tracks, objects, recall, expected):
    """Inputs and counts are those of `test_gt_submission` and so on in `nuscenes/eval/tracking/tests/test_algo.py`."""
    assert counted(curve(one_car(tracks, objects)), recall) == expected


def test_an_empty_submission_to_nuscenes():
    """`test_empty_submission`: MOTAR is 0, and no recall is reached."""
    points = curve(one_car({}))
    assert all(point.motar == 0.0 and point.counts is None for point in points)
    assert average(points) == (0.0, WORST_MOTP_M)


def test_the_average_counts_recalls_that_are_not_reached_as_the_worst():
    """Three of four frames: recalls up to 0.75 are reached, 29 of 40, with MOTAR 1 and MOTP 0 m."""
    reached = sum(recall <= 0.75 for recall in np.linspace(0.1, 1.0, 40))
    assert reached == 29
    found = average(curve(one_car({0: [5], 2: [5], 3: [5]})))
    assert found == pytest.approx((29 / 40, 2.0 * 11 / 40), abs=1e-12)
    assert len(RECALLS) == 40


def test_unsure_false_tracks_lower_only_the_recalls_that_need_them():
    """Two cars in four frames. Car 0 has a track of score 0.9. Car 1 has one of score 0.3, as a false track has.

    Recalls up to 0.5 have the threshold 0.9: MOTAR = 1. np.interp falls linearly from 0.9 to 0.3 between the recalls
    4/8 and 5/8, so all tracks count where the threshold is 0.3: FP = 4, FN = 0, MOTAR = 1 - 4 / 8.
    """
    far = np.array([[0.0, 9.0, 9.0], [9.0, 1.0, 9.0]])
    steps = [DistanceStep(np.array([0, 1]), np.array([0, 1, 2]), far) for _ in range(4)]
    points = recall_curve(steps, [np.array([0.9, 0.3, 0.3])] * 4, 2.0)
    for point in points:
        assert point.motar == pytest.approx(1.0 if point.recall < 5 / 8 else 0.5, abs=1e-12), point
        assert point.motp_m == pytest.approx(0.0 if point.recall < 5 / 8 else 0.5, abs=1e-12), point


DEVKIT = {
    0: (0.5412151626098106, 0.9656944154647935),
    1: (0.43328257953376725, 1.1942045059032576),
    2: (0.5167956396605465, 1.0664822874618234),
    3: (0.5690321448363728, 0.909563338259947),
    4: (0.5817337903645384, 0.9433468203786564),
    5: (0.5593941499113912, 0.9523086703116903),
}
"""AMOTA and AMOTP [m] that nuScenes' development kit 1.2.0 printed by `tests/support/devkit_averages.py`, by seed."""


@pytest.mark.parametrize("seed", DEVKIT)
def test_averages_are_those_of_nuscenes_development_kit(seed, tmp_path, capsys):
    """Drives with gaps, switched ids, false tracks and scores per box."""
    metrics = graded(tmp_path, *box_files.drive(seed, devkit_averages.FRAMES, devkit_averages.CARS), capsys)
    found = [metrics[f"track.{name}"]["value"] for name in ("amota", "amotp_m")]
    assert found == pytest.approx(DEVKIT[seed], abs=1e-9)
