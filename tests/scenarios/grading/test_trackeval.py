"""HOTA, CLEAR and Identity of real runs, compared with trackeval's own file format, reader and evaluator.

The boxes of these runs are written as MOT Challenge files; trackeval reads the files, matches ids and frames, and
evaluates.
"""

import numpy as np
import pandas as pd
import pytest
from support import naive_grading as naive
from support.optional import need
from support.paths import EXAMPLES
from support.scripts import load_script

from luxloop.scenarios import execute
from luxloop.scenarios.files import shipped as listing
from luxloop.scenarios.files.scenario import Scenario
from luxloop.scenarios.grading.grader import grade
from luxloop.scenarios.grading.grading_config import GradingConfig
from luxloop.scenarios.grading.plane_geometry import iou_table
from luxloop.scenarios.offline.recorded_scans import RecordedRun
from luxloop.scenarios.offline.regrade import Regrader
from luxloop.scenarios.run import device

DURATION_S = 4.8
BOX = ["x_world_m", "y_world_m", "yaw_world_rad", "length_m", "width_m"]
PEDESTRIAN = 1
"""Class id of pedestrians, the only evaluated class of MOT Challenge."""
THEIRS = {
    "track.hota": ("HOTA", "HOTA"),
    "track.deta": ("HOTA", "DetA"),
    "track.assa": ("HOTA", "AssA"),
    "track.loca": ("HOTA", "LocA"),
    "track.mota": ("CLEAR", "MOTA"),
    "track.id_switches": ("CLEAR", "IDSW"),
    "track.fragments": ("CLEAR", "Frag"),
    "track.missed": ("CLEAR", "CLR_FN"),
    "track.false": ("CLEAR", "CLR_FP"),
    "track.idf1": ("Identity", "IDF1"),
}
QUIET = {"PRINT_CONFIG": False}
SILENT = (*QUIET, "PRINT_RESULTS", "TIME_PROGRESS", "OUTPUT_SUMMARY", "OUTPUT_DETAILED", "PLOT_CURVES")
GT, TRACKS = "gt/run/gt/gt.txt", "trackers/ours/data/run.txt"

my_tracker = load_script(EXAMPLES / "my_tracker.py")


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    """The same scans of SUMO traffic at a crossing, tracked by the shipped tracker and by a simple one."""
    out = tmp_path_factory.mktemp("trackeval") / "run"
    scenario = Scenario.load(listing.find("sumo-crossing"), {"duration_s": DURATION_S})
    shipped = execute.execute(scenario, device.load(device.SHIPPED), out, record=False, record_scans=True)
    run = RecordedRun.open(out)
    poor = Regrader(run, run.scenario).tracker(my_tracker.PatchTracker, "poor")
    return {"shipped": shipped, "poor": poor}


def counted(result):
    """Graded vehicles, and the tracks on them or on no actor."""
    truth, tracks = result.tables["truth"], result.tables["tracks"]
    return truth[truth["graded"]], tracks[tracks["verdict"].isin(["graded", "false"])]


def write(path, rows, ids, boxes):
    """Write a MOT Challenge file: frame from 1, id, left, top, width, height, 1, class, 1."""
    lines = [
        ",".join(map(repr, (int(frame) + 1, int(name) + 1, *map(float, box), 1, PEDESTRIAN, 1)))
        for frame, name, box in zip(rows["frame"], rows[ids], boxes, strict=True)
    ]
    path.parent.mkdir(parents=True)
    path.write_text("\n".join(lines) + "\n")


def evaluate(folder, frames, dataset=None):
    """Evaluate the files with trackeval's evaluator, by default as its MOT challenge format."""
    need("dev", "trackeval")
    from trackeval import Evaluator
    from trackeval.datasets import MotChallenge2DBox
    from trackeval.metrics import CLEAR, HOTA, Identity

    config = {
        **QUIET,
        "GT_FOLDER": str(folder / "gt"),
        "TRACKERS_FOLDER": str(folder / "trackers"),
        "SEQ_INFO": {"run": frames},
        "SKIP_SPLIT_FOL": True,
    }
    silent = dict.fromkeys(
        ("PRINT_RESULTS", "TIME_PROGRESS", "OUTPUT_SUMMARY", "OUTPUT_DETAILED", "PLOT_CURVES"), False
    )
    evaluator = Evaluator({**QUIET, **silent, "LOG_ON_ERROR": None})
    data = (dataset or MotChallenge2DBox)(config)
    found, _ = evaluator.evaluate([data], [HOTA(), CLEAR(QUIET), Identity(QUIET)])
    families = found[data.get_name()]["ours"]["run"]["pedestrian"]
    return {name: float(np.mean(families[family][field])) for name, (family, field) in THEIRS.items()}


@pytest.mark.parametrize("tracker", ["shipped", "poor"])
def test_metrics_of_a_run_equal_trackevals(tracker, results, tmp_path):
    """Rotated boxes, for which trackeval has no overlap; it gets an independent one by polygon clipping."""
    need("dev", "trackeval")
    from trackeval.datasets import MotChallenge2DBox

    result = results[tracker]
    truth, tracks = counted(result)
    heading = {}

    class BirdsEye(MotChallenge2DBox):
        def _calculate_similarities(self, gt_dets_t, tracker_dets_t):
            def full(box):
                x, y, length, width = box.tolist()
                return np.array([x, y, heading[x, y, length, width], length, width])

            overlap = [[naive.iou(full(a), full(b)) for b in tracker_dets_t] for a in gt_dets_t]
            return np.reshape(overlap, (len(gt_dets_t), len(tracker_dets_t)))

    for path, rows, ids in (
        ("gt/run/gt/gt.txt", truth, "actor_id"),
        ("trackers/ours/data/run.txt", tracks, "track_id"),
    ):
        boxes = rows[BOX].to_numpy()
        heading |= {(x, y, length, width): yaw for x, y, yaw, length, width in boxes.tolist()}
        write(tmp_path / path, rows, ids, boxes[:, [0, 1, 3, 4]])
    theirs = evaluate(tmp_path, result.frames, BirdsEye)
    assert {name: result.metrics[name].value for name in THEIRS} == pytest.approx(theirs, abs=1e-9)


@pytest.mark.parametrize("tracker", ["shipped", "poor"])
def test_metrics_of_axis_aligned_boxes_equal_trackevals(tracker, results, tmp_path):
    """Every box is replaced by its axis-aligned bounding box; overlaps are trackeval's own, too."""
    result = results[tracker]
    counted_truth, counted_tracks = (upright(rows) for rows in counted(result))
    write(tmp_path / GT, counted_truth, "actor_id", corner_first(counted_truth))
    write(tmp_path / TRACKS, counted_tracks, "track_id", corner_first(counted_tracks))
    theirs = evaluate(tmp_path, result.frames)
    truth, tracks = (upright(result.tables[name]) for name in ("truth", "tracks"))
    boxes = {**result.tables, "truth": truth, "tracks": tracks, "overlaps": overlaps(truth, tracks)}
    metrics = grade(boxes, GradingConfig(), result.frames)
    assert {name: metrics[name].value for name in THEIRS} == pytest.approx(theirs, abs=1e-9)
    turned = iou_table(counted_truth[BOX].to_numpy(), counted(result)[0][BOX].to_numpy()).diagonal()
    assert turned.min() < 0.9, "no box changed: vehicles must stand askew for this test"


def test_runs_have_tracking_errors(results):
    """Metrics of perfect tracks would agree for any counting rule."""
    shipped, poor = ({name: result.metrics[name].value for name in THEIRS} for result in results.values())
    assert 0.6 < shipped["track.hota"] < 0.95
    assert poor["track.hota"] < shipped["track.hota"]
    assert min(poor[f"track.{name}"] for name in ("id_switches", "fragments", "missed", "false")) >= 1
    assert shipped["track.missed"] > 0


def upright(rows):
    """Axis-aligned bounding boxes of the boxes."""
    cos, sin = np.abs(np.cos(rows["yaw_world_rad"])), np.abs(np.sin(rows["yaw_world_rad"]))
    length, width = rows["length_m"], rows["width_m"]
    return rows.assign(yaw_world_rad=0.0, length_m=length * cos + width * sin, width_m=length * sin + width * cos)


def corner_first(rows):
    """Left, top, width, height."""
    x, y, _, length, width = rows[BOX].to_numpy().T
    return np.column_stack([x - 0.5 * length, y - 0.5 * width, length, width])


def overlaps(truth, tracks):
    """Overlap table of changed boxes."""
    parts = []
    for frame, rows in tracks.groupby("frame"):
        actors = truth[truth["frame"] == frame]
        table = iou_table(actors[BOX].to_numpy(), rows[BOX].to_numpy())
        actor, row = np.nonzero(table)
        ids = {"actor_id": actors["actor_id"].to_numpy()[actor], "track_id": rows["track_id"].to_numpy()[row]}
        parts.append(pd.DataFrame({"frame": frame, **ids, "iou": table[actor, row]}))
    return pd.concat(parts)
