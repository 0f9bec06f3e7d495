"""Readers of boxes: every format gives the same boxes and metrics, and an invalid file is refused in one line."""

import json

import numpy as np
import pandas as pd
import pytest
from support import box_files
from support.box_files import Box
from support.optional import need

from luxloop.scenarios.cli import main
from luxloop.scenarios.exchange.file_formats import HEAD_BYTES, read, recognise
from luxloop.scenarios.exchange.kitti import kitti_labels
from luxloop.scenarios.exchange.nuscenes import nuscenes_reader

KITTI_LINE = "0 7 Car 0 0 -1.57 599.4 156.4 629.8 189.3 1.50 1.60 3.80 -2.0 1.65 12.0 0.00"
"""A line in the layout of `label_02`: a car 12 m ahead and 2 m to the left, that faces to the right."""
NAMES = {"csv": "{}.csv", "kitti": "{}.txt", "nuscenes": "{}.json", "parquet": "{}.parquet"}


def write(folder, file_format, name, boxes, *, scored=True):
    path = folder / NAMES[file_format].format(name)
    if file_format == "parquet":
        path.write_bytes(b"")
        csv = box_files.write(folder, f"{name}-rows.csv", box_files.csv(boxes))
        pd.read_csv(csv).to_parquet(path)
    elif file_format == "csv":
        path.write_text(box_files.csv(boxes))
    else:
        path.write_text(getattr(box_files, file_format)(boxes, scored=scored))
    return path


@pytest.mark.parametrize("file_format", NAMES)
def test_all_formats_give_the_same_boxes(file_format, tmp_path):
    truth, _ = box_files.drive(3)
    path = write(tmp_path, file_format, "a", truth)
    assert recognise(path) == file_format
    (found,) = read(path, "truth")
    assert found.id.tolist() == [box.id for box in truth]
    expected = [(b.x, b.y, b.heading, b.length, b.width) for b in truth]
    np.testing.assert_allclose(found.boxes, expected, atol=1e-12)
    np.testing.assert_allclose(found.score, [b.score for b in truth])
    assert set(found.kind.tolist()) == {"car"}


def test_all_formats_give_the_same_metrics(tmp_path, capsys):
    truth, tracks = box_files.drive(1)
    sheets = []
    for file_format in NAMES:
        a, b = write(tmp_path, file_format, "a", truth, scored=False), write(tmp_path, file_format, "b", tracks)
        assert main(["grade", "--truth", str(a), "--tracks", str(b), "--json"]) == 0
        metrics = json.loads(capsys.readouterr().out)["metrics"]
        sheets.append({name: found["value"] for name, found in metrics.items()})
    for name, value in sheets[0].items():
        if value is not None:  # a metric of velocities or heights, which not all formats have
            assert [sheet[name] for sheet in sheets] == pytest.approx([value] * 4, abs=1e-9), name
    assert 0.1 < sheets[0]["track.amota"] < 0.95
    assert sheets[2]["track.velocity_abs_mean_mps"] == 0.0


def test_axes_of_kitti(tmp_path):
    """x right, z forward; rotation_y is 0 along x, clockwise from above, about the bottom centre."""
    found = kitti_labels.read(
        box_files.write(
            tmp_path, "a.txt", KITTI_LINE + "\n1 -1 DontCare -1 -1 -10 0 0 1 1 -1 -1 -1 -1000 -1000 -1000 -10\n"
        )
    )
    np.testing.assert_allclose(found.boxes, [[12.0, 2.0, -np.pi / 2, 3.8, 1.6]], atol=1e-12)
    assert (found.z_m[0], found.height_m[0], found.kind[0]) == (pytest.approx(-0.9), 1.5, "car")
    assert found.score is None
    away = kitti_labels.read(box_files.write(tmp_path, "b.txt", KITTI_LINE.replace(" 0.00", " -1.570796326794897")))
    assert away.boxes[0, 2] == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize("angle", [-3.0, -0.4, 0.0, 1.3, 3.1])
def test_headings_of_quaternions(angle):
    """Turns about z, with a pitch afterwards as on a slope, keep their heading; the norm is 1."""
    turn = np.array([np.cos(angle / 2), 0.0, 0.0, np.sin(angle / 2)])
    pitch = np.array([np.cos(0.05), 0.0, np.sin(0.05), 0.0])
    w = turn[0] * pitch[0]
    pitched = np.array([w, -turn[3] * pitch[2], turn[0] * pitch[2], turn[3] * pitch[0]])
    assert nuscenes_reader.yaw(turn) == pytest.approx(angle, abs=1e-12)
    assert nuscenes_reader.yaw(pitched) == pytest.approx(angle, abs=1e-12)


def scene(folder, stamps_s=(0.0, 0.5, 1.0, 4.0), **changes):
    """A nuScenes folder with one car that moves 2 m/s along x, and a stroller, which the tracking task ignores."""
    samples = [{"token": f"s{k}", "timestamp": round(1e6 * t), "scene_token": "c"} for k, t in enumerate(stamps_s)]
    rows = []
    for name, y in (("car", 0.0), ("stroller", 5.0)):
        for k, t in enumerate(stamps_s):
            links = {"prev": f"{name}{k - 1}" if k else "", "next": f"{name}{k + 1}" if k < len(stamps_s) - 1 else ""}
            box = {"translation": [2.0 * t, y, 1.0], "size": [1.8, 4.5, 1.5], "rotation": [1, 0, 0, 0]}
            rows.append({"token": f"{name}{k}", "sample_token": f"s{k}", "instance_token": f"i-{name}", **box, **links})
    tables = {
        "sample": samples[::-1],
        "sample_annotation": rows,
        "instance": [{"token": f"i-{name}", "category_token": f"c-{name}"} for name in ("car", "stroller")],
        "category": [
            {"token": "c-car", "name": "vehicle.car"}, {"token": "c-stroller", "name": "human.pedestrian.stroller"}
        ],
    }  # fmt: skip
    folder = folder / "v1.0-mini"
    folder.mkdir()
    for name, table in (tables | changes).items():
        (folder / f"{name}.json").write_text(json.dumps(table))
    return folder


def test_velocities_of_nuscenes_tables(tmp_path):
    """Differences over the neighbours, up to 1.5 s at an end and 3 s in between: 4.0 s is 3 s from its neighbour."""
    scene(tmp_path)
    found = nuscenes_reader.read_tables(tmp_path)
    assert found.kind.tolist() == ["car"] * 4
    assert found.frame.tolist() == [0, 1, 2, 3]
    np.testing.assert_allclose(found.velocity[:2], [[2.0, 0.0], [2.0, 0.0]])
    assert np.isnan(found.velocity[2:]).all()


def test_ids_of_several_scenes_are_apart(tmp_path, capsys):
    """The same track id in two scenes is two tracks: no id switch, and half of the boxes are the same identity."""
    folder = scene(tmp_path, stamps_s=(0.0, 0.1))
    samples = json.loads((folder / "sample.json").read_text())
    instances = [{"token": f"i{k}", "category_token": "c-car"} for k in range(2)]
    rows = [
        {"token": f"a{k}", "sample_token": f"s{k}", "instance_token": f"i{k}", "translation": [0, 0, 0],
         "size": [1.8, 4.5, 1.5], "rotation": [1, 0, 0, 0], "prev": "", "next": ""} for k in range(2)
    ]  # fmt: skip
    apart = [{**row, "scene_token": row["token"]} for row in samples]
    for name, table in (("sample", apart), ("instance", instances), ("sample_annotation", rows)):
        (folder / f"{name}.json").write_text(json.dumps(table))
    box = {"translation": [0, 0, 0], "size": [1.8, 4.5, 1.5], "rotation": [1, 0, 0, 0], "tracking_name": "car"}
    results = {f"s{k}": [{**box, "tracking_id": "7", "tracking_score": 1.0, "velocity": [0, 0]}] for k in range(2)}
    path = box_files.write(tmp_path, "r.json", json.dumps({"results": results}))
    assert main(["grade", "--truth", str(tmp_path), "--tracks", str(path), "--json"]) == 0
    metrics = json.loads(capsys.readouterr().out)["metrics"]
    assert metrics["track.idf1"]["value"] == metrics["track.hota"]["value"] == 1.0


def test_classes_are_filtered_and_averaged(tmp_path, capsys):
    """A car that is found, and a bus that is not: AMOTA is 1 for cars, 0 for buses, and 1/2 on average."""
    truth = [
        Box(k, kind, 9.0 * k, y, 0.0, 4.0, 2.0, kind=kind) for k in range(3) for kind, y in (("car", 0.0), ("bus", 9.0))
    ]
    tracks = [box for box in truth if box.kind == "car"]
    a, b = write(tmp_path, "csv", "a", truth), write(tmp_path, "csv", "b", tracks)
    amota = []
    for options in ([], ["--classes", "car"], ["--classes", "Bus"]):
        assert main(["grade", "--truth", str(a), "--tracks", str(b), "--json", *options]) == 0
        amota.append(json.loads(capsys.readouterr().out)["metrics"]["track.amota"]["value"])
    assert amota == [0.5, 1.0, 0.0]


def test_classes_that_the_truth_does_not_have_are_a_warning(tmp_path, capsys):
    """Names of classes in CSV are free: `carr` is as valid as `bus`, but no true box has it."""
    truth = [Box(0, "1", 0.0, 0.0, 0.0, 4.0, 2.0)]
    a, b = write(tmp_path, "csv", "a", truth), write(tmp_path, "csv", "b", [truth[0]._replace(kind="carr")])
    for options, left_out in (([], "left out of AMOTA and AMOTP"), (["--classes", "car"], "left out")):
        assert main(["grade", "--truth", str(a), "--tracks", str(b), "--json", *options]) == 0
        warnings = json.loads(capsys.readouterr().out)["warnings"]
        assert warnings == [f"the truth has no class carr: tracks of it are {left_out}"]
    assert main(["grade", "--truth", str(a), "--tracks", str(b)]) == 0
    printed = capsys.readouterr().out
    assert "Warning: the truth has no class carr" in printed
    assert "1 frame, 1 true box, 1 box of tracks" in printed
    assert main(["grade", "--truth", str(a), "--tracks", str(a), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["warnings"] == []


def test_times_of_one_frame_may_be_rounded(tmp_path, capsys):
    head = "time_s,track_id,x_odom_m,y_odom_m,heading_odom_rad,length_m,width_m,status\n"
    a = box_files.write(tmp_path, "a.csv", head + "".join(f"{0.08 * k},1,{k},0,0,4,2,confirmed\n" for k in range(4)))
    rows = "".join(f"{0.08 * k + 4e-4},1,{k},0,0,4,2,{'dead' if k == 3 else 'confirmed'}\n" for k in range(4))
    b = box_files.write(tmp_path, "b.csv", head + rows)
    assert main(["grade", "--truth", str(a), "--tracks", str(b), "--json"]) == 0
    graded = json.loads(capsys.readouterr().out)
    assert (graded["frames"], graded["metrics"]["track.mota"]["value"]) == (4, 0.75)


def test_files_without_tracks_or_truth_are_graded(tmp_path, capsys):
    truth, _ = box_files.drive(0)
    a, empty = write(tmp_path, "kitti", "a", truth, scored=False), box_files.write(tmp_path, "b.txt", "")
    for pair, found in (((a, empty), len(truth)), ((empty, a), len(truth)), ((empty, empty), 0)):
        assert main(["grade", "--truth", str(pair[0]), "--tracks", str(pair[1]), "--json"]) == 0
        metrics = json.loads(capsys.readouterr().out)["metrics"]
        if pair == (a, empty):
            assert (metrics["track.missed"]["value"], metrics["track.hota"]["value"]) == (found, 0.0)
        else:
            assert metrics["track.hota"] == {
                "value": None,
                "unit": "1",
                "n": 0,
                "reason": "no vehicle was graded",
                "interval": None,
            }
            assert metrics["track.false"]["value"] == (found or None)


def test_boxes_of_few_points_and_their_tracks_are_left_out(tmp_path, capsys):
    """Of three cars the second has 3 points: its track counts no more. The track on no car stays false."""
    truth = [Box(k, f"{car}", 0.0, 9.0 * car, 0.0, 4.0, 2.0) for k in range(2) for car in range(3)]
    tracks = [box._replace(id=f"1{box.id}", x=0.4) for box in truth if box.id != "2"]
    tracks += [Box(k, "99", 50.0, 0.0, 0.0, 4.0, 2.0) for k in range(2)]
    rows = box_files.csv(truth).splitlines()
    counted = [f"{row},{points}" for row, points in zip(rows, ["points", *[10, 3, 12] * 2], strict=True)]
    a = box_files.write(tmp_path, "a.csv", "\n".join(counted))
    b = write(tmp_path, "csv", "b", tracks)
    found = []
    for points in ("0", "10"):
        assert main(["grade", "--truth", str(a), "--tracks", str(b), "--json", "--points-min", points]) == 0
        metrics = json.loads(capsys.readouterr().out)["metrics"]
        found.append([metrics[f"track.{name}"]["value"] for name in ("missed", "false", "mota")])
    assert found == [[2, 2, pytest.approx(1 - 4 / 6)], [2, 2, pytest.approx(1 - 4 / 4)]]


def test_boxes_far_away_or_hidden_and_their_tracks_are_left_out(tmp_path, capsys):
    """By hand: cars at 10 m (found), 20 m (level 3, found), 60 m (found) and 70 m; false tracks at 30 m and 90 m.

    Beyond 50 m two true boxes, the track on one of them and the other track are left out; with level 2, one pair.
    """
    truth = [Box(0, f"{x}", x, 0.0, 0.0, 4.0, 2.0) for x in (10.0, 20.0, 60.0, 70.0)]
    tracks = [Box(0, f"{x}", x, 0.0, 0.0, 4.0, 2.0) for x in (10.0, 20.0, 60.0, 30.0, 90.0)]
    lines = box_files.kitti(truth, scored=False).splitlines()
    lines[1] = lines[1].replace("Car 0 0", "Car 0 3")
    a = box_files.write(tmp_path, "a.txt", "\n".join(lines))
    b = write(tmp_path, "kitti", "b", tracks)
    near, visible = ["--range-max", "50"], ["--occluded-max", "2"]
    found = []
    for options in ([], near, visible, near + visible):
        assert main(["grade", "--truth", str(a), "--tracks", str(b), "--json", *options]) == 0
        graded = json.loads(capsys.readouterr().out)
        counts = [graded["metrics"][f"track.{name}"]["value"] for name in ("missed", "false")]
        found.append([graded["true_boxes"], graded["track_boxes"], *counts])
    assert found == [[4, 5, 1, 2], [2, 3, 0, 1], [3, 4, 1, 2], [1, 2, 0, 1]]


HEAD = "frame,id,x_m,y_m,heading_rad,length_m,width_m"
GOOD = f"{HEAD}\n0,1,0,0,0,4,2\n"
BOX = {
    "translation": [0, 0, 0],
    "size": [2, 4, 1],
    "rotation": [1, 0, 0, 0],
    "tracking_id": "1",
    "tracking_name": "car",
}
RESULT = json.dumps({"results": {"s": [BOX]}})


def result(**changes):
    return json.dumps({"results": {"s": [BOX | changes]}})


@pytest.mark.parametrize(
    ("name", "text", "message"),
    [
        ("b.csv", "frame,id\n0,1\n", "b.csv: no columns x_m, y_m and heading_rad, nor with odom, world or ego"),
        ("b.csv", GOOD.replace("frame", "scan"), "b.csv: no column frame or time_s; add one"),
        ("b.csv", GOOD.replace(",id,", ",name,"), "b.csv: no column track_id; add it"),
        ("b.csv", GOOD + "1,1,0,0,east,4,2\n", "b.csv: column heading_rad, row 2: east: should be a number"),
        ("b.csv", GOOD + "1,1,0,0,0,4,0\n", "b.csv: row 2, width: 0: should be more than 0"),
        ("b.csv", GOOD + "0,1,0,0,0,4,2\n", "b.csv: row 2, id: 1: occurs twice in frame 0; give each id"),
        ("b.csv", f"{HEAD}\n0,0,1,0.1,0.2,4,2,9\n", "b.csv: row 1: 8 cells, but the header has 7; give"),
        ("b.csv", f"{HEAD}\n9,1,0,0,0,4,2\n", "b.csv: has no frame in common with a.csv; give tracks"),
        ("b.csv", GOOD.replace("frame", "time_s"), "b.csv: has time_s, but a.csv has frame; give both files the same"),
        ("b.txt", KITTI_LINE.replace("3.80", "long"), "b.txt: line 1, length: long: should be a number"),
        ("b.txt", f"{KITTI_LINE}\n{KITTI_LINE} 0 0", "b.txt: line 2: 19 fields; KITTI tracking has 17, and results 18"),
        ("b.txt", f"{KITTI_LINE}\n{KITTI_LINE} 0.5", "b.txt: line 2: score: only some lines have one"),
        ("b.txt", "\n" + KITTI_LINE.replace("3.80", "-1"), "b.txt: line 2, length: -1: should be more than 0"),
        ("b.txt", KITTI_LINE.replace("0 7", "0.5 7", 1), "b.txt: line 1, frame: 0.5: should be an integer"),
        ("b.csv", f"{HEAD},vx_mps\n0,1,0,0,0,4,2,9\n", "b.csv: column vx_mps without the other of vx_mps and"),
        ("b.txt", KITTI_LINE.replace("Car", "Carr"), "b.txt: line 1, type: Carr: should be one of Car, Van"),
        ("b.json", result(tracking_name="Carr"), "b.json: sample s, box 1, tracking_name: Carr: should be one of bi"),
        ("b.json", "{", "b.json: cannot be read (Expecting property name"),
        ("b.json", "{}", "b.json: file: no key results; add it"),
        ("b.json", result(size=[2, 4]), "b.json: sample s, box 1, size: [2, 4]: should be a list of 3 numbers"),
        ("b.json", result(rotation=[0, 0, 0, 0]), "b.json: sample s, box 1, rotation: norm 0: should be a quaternion"),
        ("b.json", result(tracking_id=None), "b.json: sample s, box 1, tracking_id: None: should be a text"),
        ("b.json", result(), "b.json: has sample, but a.csv has frame; give both files the same"),
        ("b.bin", "\0\0", "b.bin: no known format; name it with --truth-format or --tracks-format"),
        ("b.mcap", "\0\0", "b.mcap: cannot be read"),
        ("b.parquet", "\0\0", "b.parquet: cannot be read"),
        ("b.mcap", "\0,\0\n", "b.mcap: cannot be read ("),
        ("b.parquet", "\0,\0\n", "b.parquet: cannot be read (Parquet file size is 4 bytes"),
        ("b.bin", "\0,\0\n", "b.bin: no known format; name it with --truth-format or --tracks-format"),
    ],
)  # fmt: skip
def test_an_invalid_file_is_refused_in_one_line(name, text, message, tmp_path, monkeypatch, capfd):
    if name.endswith(".mcap"):
        need("mcap")
    monkeypatch.chdir(tmp_path)
    box_files.write(tmp_path, "a.csv", GOOD)
    box_files.write(tmp_path, name, text)
    refused(["--truth", "a.csv", "--tracks", name], message, capfd)


def refused(words, message, capfd):
    assert main(["grade", *words]) == 2
    error = capfd.readouterr().err
    assert error.startswith(f"luxloop: error: {message}"), error
    assert error.count("\n") == 1


def test_files_in_different_axes_are_refused(tmp_path, monkeypatch, capfd):
    monkeypatch.chdir(tmp_path)
    box_files.write(tmp_path, "a.csv", GOOD.replace("x_m,y_m,heading_rad", "x_world_m,y_world_m,heading_world_rad"))
    box_files.write(tmp_path, "b.txt", KITTI_LINE)
    message = "b.txt: its positions are in camera axes, those of a.csv in world axes; give both files in the same frame"
    refused(["--truth", "a.csv", "--tracks", "b.txt"], message, capfd)


@pytest.mark.parametrize(
    ("table", "rows", "message"),
    [
        ("instance", [{"token": "i-car", "category_token": "x"}], "row sa"),
        ("category", [], "v1.0-mini/instance.json: row i-car, category_token: c-car: is no token of the other table"),
        ("sample", {"token": "s0"}, "v1.0-mini/sample.json: should be a list of rows; give a nuScenes table"),
        (
            "sample",
            [{"token": "s0", "timestamp": "now", "scene_token": "c"}],
            "v1.0-mini/sample.json: row s0, timestamp: now",
        ),
    ],
)
def test_an_invalid_table_is_refused_in_one_line(table, rows, message, tmp_path, monkeypatch, capfd):
    monkeypatch.chdir(tmp_path)
    scene(tmp_path, **{table: rows})
    box_files.write(tmp_path, "b.json", RESULT)
    if table == "instance":
        message = "v1.0-mini/sample_annotation.json: row stroller0, instance_token: i-stroller: is no token"
    refused(["--truth", "v1.0-mini", "--tracks", "b.json"], message, capfd)


def test_a_kitti_folder_of_several_sequences_needs_tracks_of_them(tmp_path, monkeypatch, capfd):
    monkeypatch.chdir(tmp_path)
    labels = tmp_path / "training" / "label_02"
    labels.mkdir(parents=True)
    for name in ("0000.txt", "0001.txt"):
        box_files.write(labels, name, KITTI_LINE)
    first = "training/label_02/0000.txt"
    for folder in (".", "training"):
        refused(["--truth", folder, "--tracks", first], f"{first}: only one file has scenes; give both", capfd)
    refused(["--truth", "training/label_02/0000.txt", "--tracks", "."], ".: no results/0000.txt in it; give", capfd)


def test_a_comma_in_other_bytes_than_text_is_no_csv_file(tmp_path):
    """Latin-1 by the ending of its name; UTF-8 also where the head of the file ends within a character."""
    (tmp_path / "a.txt").write_bytes("0,é".encode("latin-1"))
    (tmp_path / "b.txt").write_bytes(b"," * (HEAD_BYTES - 1) + "é".encode())
    assert [recognise(tmp_path / name) for name in ("a.txt", "b.txt")] == ["kitti", "csv"]


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ([], "give RUN, or both of --truth FILE and --tracks FILE"),
        (["--truth", "a.csv"], "give RUN, or both of --truth FILE and --tracks FILE"),
        (["--tracks", "a.csv"], "give RUN, or both of --truth FILE and --tracks FILE"),
        (["run", "--truth", "a.csv"], "--truth cannot be given with RUN; give either RUN, or --truth FILE"),
        (["run", "--gospa-cutoff", "3"], "--gospa-cutoff cannot be given with RUN; give either RUN"),
        (["--truth", "a.csv", "--fits", "a.csv", "--tracks-format", "csv"], "--tracks-format: there are no tracks"),
        (["--truth", "a.csv", "--fits", "a.csv", "--out", "x"], "--out: there are no tracks, and fits have no page"),
        (["--truth", "a.csv", "--tracks", "a.csv", "--hit-iou", "1"], "--hit-iou 1: should lie between 0 and 1"),
        (["--truth", "a.csv", "--tracks", "a.csv", "--gospa-cutoff", "nan"], "Invalid value for '--gospa-cutoff': nan"),
        (["--truth", "a.csv", "--tracks", "a.csv", "--truth-format", "bag"], "--truth-format bag: is none of av2, csv"),
        (["--truth", "a.csv", "--tracks", "a.csv", "--classes", "car"], "a.csv: has no classes; leave --classes out"),
        (["--truth", "a.csv", "--tracks", "a.csv", "--truth-format", "kitti"], "a.csv: line 1: 1 fields; KITTI"),
        (["--truth", "a.csv", "--tracks", "a.csv", "--points-min", "1"], "a.csv: has no numbers of points; leave"),
        (["--truth", "a.csv", "--tracks", "a.csv", "--occluded-max", "1"], "a.csv: has no levels of occlusion"),
        (["--truth", "a.csv", "--tracks", "a.csv", "--occluded-max", "4"], "--occluded-max 4: should be a level"),
        (["--truth", "a.csv", "--tracks", "a.csv", "--range-max", "0"], "--range-max 0: should be more than 0"),
        (["--truth", "a.csv", "--tracks", "a.csv", "--range-max", "9"], "a.csv: its positions are in unnamed axes"),
        (["run", "--range-max", "3"], "--range-max cannot be given with RUN; give either RUN"),
        (["run", "--occluded-max", "3"], "--occluded-max cannot be given with RUN; give either RUN"),
        (["run", "--points-min", "3"], "--points-min cannot be given with RUN; give either RUN"),
        (["--truth", "none.csv", "--tracks", "a.csv"], "none.csv: cannot be read (No such file or directory)"),
        (["--truth", ".", "--tracks", "a.csv"], ".: a folder of no known format of av2, csv, kitti, mcap, nuscenes,"),
    ],
)  # fmt: skip
def test_an_invalid_request_is_refused_in_one_line(words, message, tmp_path, monkeypatch, capfd):
    monkeypatch.chdir(tmp_path)
    box_files.write(tmp_path, "a.csv", GOOD)
    refused(words, message, capfd)
