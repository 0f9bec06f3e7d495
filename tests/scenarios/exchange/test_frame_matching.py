"""Frames and scenes of two files: sequences of a folder, restarted ids, and files of other clocks and rates."""

import json

import numpy as np
import pytest
from support import box_files
from support.optional import need

need("dev", "trackeval")

from support.trackeval_input import FIELDS, trackeval_sequence
from trackeval.metrics import CLEAR, HOTA, Identity

from luxloop.scenarios.cli import main

SEQUENCES = {"0000": 3, "0007": 4}
"""Seeds of the drives by the name of the sequence; their ids are the same."""


def graded(capsys, truth, tracks, *options):
    capsys.readouterr()
    assert main(["grade", "--truth", str(truth), "--tracks", str(tracks), "--json", *options]) == 0
    return json.loads(capsys.readouterr().out)


def expected_of(drives):
    """Figures of trackeval over all drives, combined by its own rule, and of each."""
    config = {"THRESHOLD": 0.5, "PRINT_CONFIG": False}
    metrics = (HOTA(), CLEAR(dict(config)), Identity(dict(config)))
    each = {name: {} for name in drives}
    pooled = {}
    for metric in metrics:
        found = {name: metric.eval_sequence(trackeval_sequence(*drive)) for name, drive in drives.items()}
        pooled |= metric.combine_sequences(found)
        for name, values in found.items():
            each[name] |= values
    return pooled, each


@pytest.mark.parametrize("kind", ["kitti", "csv"])
def test_sequences_are_scenes_pooled_and_single_as_in_trackeval(kind, tmp_path, capsys):
    drives = {name: box_files.drive(seed) for name, seed in SEQUENCES.items()}
    paths = []
    for place, folder in enumerate(("label_02", "results")):
        (tmp_path / folder).mkdir()
        if kind == "kitti":
            for name, drive in drives.items():
                text = box_files.kitti(drive[place], scored=folder == "results")
                box_files.write(tmp_path / folder, f"{name}.txt", text)
            paths.append(tmp_path / folder)
        else:
            lines = [box_files.csv(drive[place]).splitlines() for drive in drives.values()]
            rows = [f"{line},s{name}" for name, part in zip(drives, lines, strict=True) for line in part[1:]]
            text = "\n".join([f"{lines[0][0]},scene", *rows])
            paths.append(box_files.write(tmp_path / folder, "boxes.csv", text))
    pooled, each = expected_of(drives)
    found = graded(capsys, *paths)
    for name, field in FIELDS.items():
        assert found["metrics"][f"track.{name}"]["value"] == pytest.approx(float(np.mean(pooled[field])), abs=1e-9), (
            name
        )
    assert len(found["scenes"]) == 2
    for figures, values in zip(found["scenes"].values(), each.values(), strict=True):
        for name in ("hota", "idf1", "missed", "false", "id_switches"):
            assert figures[f"track.{name}"] == pytest.approx(float(np.mean(values[FIELDS[name]])), abs=1e-9)


def written(folder, truth, tracks, *, step_s=0.1, late_s=0.0):
    """Write two files with times in place of frames."""
    paths = []
    for name, boxes, late in (("truth.csv", truth, 0.0), ("tracks.csv", tracks, late_s)):
        lines = box_files.csv(boxes).replace("frame,", "time_s,", 1).splitlines()
        rows = [
            ",".join([repr(step_s * b.frame + late), row.split(",", 1)[1]])
            for b, row in zip(boxes, lines[1:], strict=True)
        ]
        paths.append(box_files.write(folder, name, "\n".join([lines[0], *rows])))
    return paths


def test_an_offset_and_a_tolerance_pair_files_of_other_clocks(tmp_path, capsys):
    truth, tracks = box_files.drive(3)
    own = graded(capsys, *written(tmp_path, truth, tracks))
    assert not own["warnings"]
    late = written(tmp_path, truth, tracks, late_s=0.03)
    assert main(["grade", "--truth", str(late[0]), "--tracks", str(late[1]), "--json"]) != 0
    assert "has no frame in common" in capsys.readouterr().err
    for options in (("--time-offset=-0.03",), ("--time-tolerance", "0.04")):
        found = graded(capsys, *late, *options)
        for name in ("hota", "idf1", "missed", "false"):
            assert found["metrics"][f"track.{name}"]["value"] == own["metrics"][f"track.{name}"]["value"]


def test_numbers_from_one_are_told_and_shifted(tmp_path, capsys):
    truth, tracks = box_files.drive(3)
    box_files.write(tmp_path, "truth.csv", box_files.csv(truth))
    box_files.write(tmp_path, "tracks.csv", box_files.csv([b._replace(frame=b.frame + 1) for b in tracks]))
    wrong = graded(capsys, tmp_path / "truth.csv", tmp_path / "tracks.csv")
    assert [line for line in wrong["warnings"] if "give --frame-offset -1" in line]
    found = graded(capsys, tmp_path / "truth.csv", tmp_path / "tracks.csv", "--frame-offset=-1")
    box_files.write(tmp_path, "same.csv", box_files.csv(tracks))
    own = graded(capsys, tmp_path / "truth.csv", tmp_path / "same.csv")
    assert not found["warnings"]
    assert found["metrics"]["track.hota"]["value"] == own["metrics"]["track.hota"]["value"] > 0.4
    assert wrong["metrics"]["track.hota"]["value"] < 0.2


def test_truth_of_every_third_frame_is_told_and_graded_there(tmp_path, capsys):
    truth, tracks = box_files.drive(3)
    box_files.write(tmp_path, "truth.csv", box_files.csv([b for b in truth if b.frame % 3 == 0]))
    box_files.write(tmp_path, "tracks.csv", box_files.csv(tracks))
    box_files.write(tmp_path, "fewer.csv", box_files.csv([b for b in tracks if b.frame % 3 == 0]))
    whole = graded(capsys, tmp_path / "truth.csv", tmp_path / "tracks.csv")
    assert whole["warnings"] == [
        "0 of 4 frames with true boxes have no tracks, 8 of 12 with tracks no true boxes; for other clocks and rates: "
        "--time-offset, --time-tolerance, --frame-offset, --common-frames"
    ]
    found = graded(capsys, tmp_path / "truth.csv", tmp_path / "tracks.csv", "--common-frames")
    own = graded(capsys, tmp_path / "truth.csv", tmp_path / "fewer.csv")
    assert not found["warnings"]
    for name in ("hota", "idf1", "missed", "false", "gospa_m"):
        assert found["metrics"][f"track.{name}"]["value"] == own["metrics"][f"track.{name}"]["value"]
