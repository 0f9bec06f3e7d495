"""Rows of recorded scans: written by the rule by which they are read, and read in the order of frames and vehicles."""

import json

import numpy as np
import pyarrow.parquet as pq
import pytest

from luxloop.scenarios.errors import InputError, OutputError
from luxloop.scenarios.recordings import recording_writer
from luxloop.scenarios.recordings.recording import Recording
from luxloop.scenarios.recordings.recording_writer import LABELS
from luxloop.tracker.scan import Scan

SUMMARY = {"files": ["a.bag"], "duration_s": 0.1, "frames": 2, "mounts": [{"origin_ego_m": [0.0, 0.0, 1.0]}]}


def write(folder, x_m=5.0, x_world_m=9.0):
    """Write two scans of one point with two vehicles each."""
    with recording_writer.create(folder, labelled=True) as (_, writer):
        for frame in range(2):
            writer.add(Scan.from_points(0.1 * frame, np.array([[x_m, 0.0, 0.5]]), np.zeros(3)))
        for frame in range(2):
            rows = {column.name: np.zeros(2) for column in LABELS} | {"frame": np.full(2, frame)}
            rows |= {"actor_id": np.arange(2), "name": np.array(["a", "b"]), "x_world_m": np.array([x_world_m, -5.0])}
            rows |= dict.fromkeys(("length_m", "width_m", "height_m"), np.full(2, 1.8))
            writer.label(rows | {name: np.zeros(2, np.int64) for name in ("kind", "mode")})
        writer.finish(SUMMARY, "Made by hand.")
    return folder


def reorder(folder, rows):
    path = folder / "labels.parquet"
    pq.write_table(pq.read_table(path).take(rows), path)


def test_labels_of_a_frame_in_another_order_are_the_same_vehicles(tmp_path):
    """The classifier of motion needs rising ids."""
    recording = Recording(write(tmp_path / "rec"))
    reorder(recording.folder, [1, 0, 3, 2])
    for frame, _, _ in recording.frames():
        assert frame.actors.id.tolist() == [0, 1]
        assert frame.actors.name.tolist() == ["a", "b"]
        assert frame.actors.pose_world[:, 0].tolist() == [9.0, -5.0]


def test_rows_in_another_order_of_frames_are_refused(tmp_path):
    recording = Recording(write(tmp_path / "rec"))
    reorder(recording.folder, [2, 3, 0, 1])
    with pytest.raises(OutputError, match=r"the rows should be in the order of column frame\); import"):
        list(recording.frames())


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"x_m": 1e30}, r"scan 0: points\.parquet, column x_ego_m: 1e\+30 is no plausible number"),
        ({"x_world_m": np.inf}, r"labels\.parquet, column x_world_m: inf is no plausible number"),
    ],
)
def test_nothing_is_imported_that_would_be_refused_when_it_is_read(tmp_path, changes, message):
    with pytest.raises(InputError, match=message):
        write(tmp_path / "rec", **changes)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("frames", [0, 3, 10**30])
def test_another_number_of_frames_is_refused(frames, tmp_path):
    summary = write(tmp_path / "rec") / "summary.json"
    summary.write_text(json.dumps(json.loads(summary.read_text()) | {"frames": frames}))
    with pytest.raises(OutputError, match=f"has 2 of {frames} scans"):
        Recording(tmp_path / "rec")
