"""HOTA, CLEAR and Identity against trackeval, on random sequences with empty steps and ties; and by hand."""

import numpy as np
import pytest
from support.optional import need

need("dev", "trackeval")

from hypothesis import given
from hypothesis import strategies as st
from support.sequences import random_sequence
from trackeval.metrics import CLEAR, HOTA, Identity

from luxloop.scenarios.grading.tracking_scores import ALPHAS, TrackingScores, VehicleScores

MEANS = {"hota": "HOTA", "deta": "DetA", "assa": "AssA", "loca": "LocA"}
VALUES = {
    "mota": "MOTA", "idf1": "IDF1", "id_switches": "IDSW", "fragments": "Frag", "missed": "CLR_FN", "false": "CLR_FP",
}  # fmt: skip


def theirs(sequence, hit_iou):
    """All figures of trackeval by our names."""
    limit = {"THRESHOLD": hit_iou, "PRINT_CONFIG": False}
    found = {}
    for metric in (HOTA(), CLEAR(limit), Identity(dict(limit))):
        found |= metric.eval_sequence(sequence)
    means = {name: np.mean(found[field]) for name, field in MEANS.items()}
    most = np.max(found["HOTA_TP"])
    return means | {name: found[field] for name, field in VALUES.items()} | {"most_matches": most}


def ours(sequence, hit_iou):
    scores = TrackingScores.of(VehicleScores.of(sequence, hit_iou))
    return {name: getattr(scores, name) for name in TrackingScores.__dataclass_fields__}


@given(
    seed=st.integers(0, 2**32 - 1),
    vehicles=st.integers(0, 6),
    tracks=st.integers(0, 6),
    empty=st.sampled_from([0.0, 0.3, 0.9]),
    steps=st.sampled_from([1, 2, 4, 20, 1000]),
    hit_iou=st.sampled_from([0.05, 0.3, 0.5, 0.75, 1.0]),
)
def test_every_score_equals_trackevals(seed, vehicles, tracks, empty, steps, hit_iou):
    sequence = random_sequence(seed, vehicles, tracks, empty, steps)
    assert ours(sequence, hit_iou) == pytest.approx(theirs(sequence, hit_iou), rel=0.0, abs=1e-12)


def sequence_of(frames):
    """A sequence from the vehicles, tracks and overlaps of each time step."""
    gt, seen = ([np.array(frame[k], np.int64) for frame in frames] for k in (0, 1))
    return {
        "num_timesteps": len(frames),
        "num_gt_ids": len({v for ids in gt for v in ids.tolist()}),
        "num_tracker_ids": len({t for ids in seen for t in ids.tolist()}),
        "num_gt_dets": sum(map(len, gt)),
        "num_tracker_dets": sum(map(len, seen)),
        "gt_ids": gt,
        "tracker_ids": seen,
        "similarity_scores": [np.reshape(frame[2], (len(frame[0]), len(frame[1]))) for frame in frames],
    }


@pytest.mark.parametrize(
    "frames",
    [
        [],
        [([], [], []), ([], [], [])],
        [([], [0], []), ([0], [], [])],
        [([0], [], []), ([0], [], [])],
        [([], [0], [])],
        [([0], [0], [0.0])],
        [([0, 1], [0, 1], [0.6] * 4)] * 3,
    ],
    ids=["no step", "nothing", "never both", "no tracks", "no truth", "no overlap", "all equal"],
)
def test_scores_of_extreme_sequences_equal_trackevals(frames):
    sequence = sequence_of(frames)
    assert ours(sequence, 0.5) == pytest.approx(theirs(sequence, 0.5), rel=0.0, abs=1e-12)


def test_scores_by_hand():
    """Two vehicles in four steps: one is followed by two tracks in turn, one is lost in step 2; one track is false.

    Every overlap is 0.8, so that 16 of the 19 thresholds are reached, with TP = 7, FN = 1 and FP = 1.
    """
    both, lost = ([0, 1], [0, 1], [0.8, 0.0, 0.0, 0.8]), ([0, 1], [0, 3], [0.8, 0.0, 0.0, 0.0])
    last = ([0, 1], [2, 1], [0.8, 0.0, 0.0, 0.8])
    scores = ours(sequence_of([both, both, lost, last]), 0.5)
    reached = np.count_nonzero(ALPHAS < 0.8 + 1e-9) / len(ALPHAS)
    assert reached == 16 / 19
    deta = 7 / 9
    assa = (3 * 3 / 4 + 1 * 1 / 4 + 3 * 3 / 4) / 7
    assert (scores["deta"], scores["assa"]) == pytest.approx((reached * deta, reached * assa))
    assert scores["hota"] == pytest.approx(reached * np.sqrt(deta * assa))
    assert scores["loca"] == pytest.approx(0.8 * reached + 1.0 - reached)
    assert scores["mota"] == pytest.approx(1 - (1 + 1 + 1) / 8)
    assert scores["idf1"] == pytest.approx(2 * 6 / (8 + 8))
    counts = [scores[name] for name in ("id_switches", "fragments", "missed", "false", "most_matches")]
    assert counts == [1, 1, 1, 1, 7]
