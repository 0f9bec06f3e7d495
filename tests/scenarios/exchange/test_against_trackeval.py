"""Metrics of files against trackeval's classes on similarities that shapely computes, and against a slow GOSPA."""

import json
from itertools import permutations

import numpy as np
import pytest
from support.few import few
from support.optional import need

need("dev", "trackeval")

from support import box_files
from support.trackeval_input import FIELDS, overlap, trackeval_sequence
from trackeval.metrics import CLEAR, HOTA, Identity

from luxloop.scenarios.cli import main

SEEDS = range(6)


def run(folder, truth, tracks, capsys, *options):
    paths = [str(box_files.write(folder, f"{n}.csv", box_files.csv(b))) for n, b in (("a", truth), ("b", tracks))]
    assert main(["grade", "--truth", paths[0], "--tracks", paths[1], "--json", *options]) == 0
    return json.loads(capsys.readouterr().out)["metrics"]


@pytest.mark.parametrize("seed", few(SEEDS, *SEEDS[:2]))
@pytest.mark.parametrize("hit_iou", [0.5, 0.3])
def test_scores_are_those_of_trackeval(seed, hit_iou, tmp_path, capsys):
    truth, tracks = box_files.drive(seed)
    sequence = trackeval_sequence(truth, tracks)
    limits = {"THRESHOLD": hit_iou, "PRINT_CONFIG": False}
    expected = {
        **HOTA().eval_sequence(sequence), **CLEAR(limits).eval_sequence(sequence),
        **Identity(dict(limits)).eval_sequence(sequence),
    }  # fmt: skip
    metrics = run(tmp_path, truth, tracks, capsys, "--hit-iou", str(hit_iou))
    for name, field in FIELDS.items():
        assert metrics[f"track.{name}"]["value"] == pytest.approx(float(np.mean(expected[field])), abs=1e-9), name
    assert metrics["track.id_switches"]["value"] + metrics["track.missed"]["value"] > 0


def slow_gospa(truth, tracks, cutoff_m):
    """Definition 1 of Rahmathullah et al. 2017 for alpha = 2 and p = 2: the least over all permutations."""
    few, many = sorted((truth, tracks), key=len)
    cost = min(
        sum(min(np.hypot(a.x - b.x, a.y - b.y), cutoff_m) ** 2 for a, b in zip(few, chosen, strict=True))
        for chosen in permutations(many, len(few))
    )
    return np.sqrt(cost + 0.5 * cutoff_m**2 * (len(many) - len(few)))


@pytest.mark.parametrize("seed", few(SEEDS, *SEEDS[:2]))
@pytest.mark.parametrize("cutoff_m", [0.5, 2.0, 15.0])
def test_gospa_is_the_least_over_all_permutations(seed, cutoff_m, tmp_path, capsys):
    truth, tracks = box_files.drive(seed, frames=4)
    metrics = run(tmp_path, truth, tracks, capsys, "--gospa-cutoff", str(cutoff_m))
    frames = sorted({b.frame for b in (*truth, *tracks)})
    each = [slow_gospa(*([b for b in boxes if b.frame == f] for boxes in (truth, tracks)), cutoff_m) for f in frames]
    assert metrics["track.gospa_m"]["value"] == pytest.approx(np.mean(each), abs=1e-9)


def test_errors_of_pairs_are_those_of_hand_made_boxes(tmp_path, capsys):
    truth = [box_files.Box(k, "t", 10.0 * k, 5.0, 3.1, 4.0, 2.0) for k in range(3)]
    tracks = [b._replace(x=b.x + 0.3, y=b.y - 0.4, heading=-3.1, length=4.5, width=1.7) for b in truth]
    metrics = run(tmp_path, truth, tracks, capsys)
    expected = {
        "position_abs_mean_m": 0.5, "length_abs_mean_m": 0.5, "width_abs_mean_m": 0.3,
        "orientation_abs_mean_deg": np.degrees(2 * np.pi - 6.2), "iou_mean": overlap(truth[0], tracks[0]),
    }  # fmt: skip
    for name, value in expected.items():
        assert metrics[f"track.{name}"]["value"] == pytest.approx(value, abs=1e-9), name
        assert metrics[f"track.{name}"]["n"] == 3
    reasons = {metric["reason"] for metric in metrics.values() if metric["value"] is None}
    lacking = {f"a.csv has no {what}" for what in ("velocities", "heights", "times", "numbers of points")}
    assert reasons == {*lacking, "no graded vehicle was longer than 6 m"}
    assert metrics["track.heading_abs_mean_deg"]["reason"] == "a.csv has no velocities"
