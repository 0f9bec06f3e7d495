"""Grading by the rules of KITTI's benchmark against trackeval's `Kitti2DBox`, on files that this test writes."""

import json
from contextlib import redirect_stdout
from io import StringIO

import numpy as np
import pytest
from support.optional import need
from support.trackeval_input import FIELDS

need("dev", "trackeval")

from trackeval import Evaluator
from trackeval.datasets import Kitti2DBox
from trackeval.metrics import CLEAR, HOTA, Identity

from luxloop.scenarios.cli import main

SEQUENCES, FRAMES = ("0000", "0001"), 30
ON_THE_GROUND = "1.5 1.6 4.0 {x:.2f} 1.7 20.0 0.0"
KINDS = ("Car", "Car", "Car", "Van", "Pedestrian", "Misc")


def line(frame, number, kind, box, levels=(0, 0), *, score=""):
    image = " ".join(repr(float(side)) for side in box)
    ground = ON_THE_GROUND.format(x=frame + 10.0 * float(number))
    return f"{frame} {number} {kind} {levels[0]} {levels[1]} 0 {image} {ground}{score}\n"


def sequence(seed):
    """Return labels and results: moving objects, their tracks, low and false tracks, and a region without labels."""
    rng = np.random.default_rng(seed)
    at, step = rng.uniform([0, 100], [900, 250], (len(KINDS), 2)), rng.uniform(-8, 8, (len(KINDS), 2))
    size = rng.uniform([40, 30], [140, 90], (len(KINDS), 2))
    labels, results = "", ""
    for frame in range(FRAMES):
        labels += f"{frame} -1 DontCare -1 -1 -10 600.0 120.0 900.0 320.0 -1000 -1000 -1000 -10 -1 -1 -1\n"
        for number, kind in enumerate(KINDS):
            box = np.concatenate([at[number], at[number] + size[number]]) + np.tile(frame * step[number], 2)
            levels = (int(rng.random() < 0.1), 3 * int(rng.random() < 0.1))
            labels += line(frame, number, kind, box, levels)
            if rng.random() < 0.85:
                noise, track = rng.normal(0.0, 6.0, 4), number + 10 * int(frame > 15 and number < 2)
                # vans are taken for cars
                results += line(frame, track, kind.replace("Van", "Car"), box + noise, score=f" {rng.random():.3f}")
        for number in (30, 31, 32):
            corner = rng.uniform([400, 100], [900, 250], 2)
            side = rng.uniform([30, 15], [120, 60], 2)
            results += line(frame, number, "Car", np.concatenate([corner, corner + side]), score=" 0.5")
    return labels, results


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("kitti")
    for place in ("label_02", "trackers/mine/data"):
        (folder / place).mkdir(parents=True)
    for seed, name in enumerate(SEQUENCES):
        labels, results = sequence(seed)
        (folder / "label_02" / f"{name}.txt").write_text(labels)
        (folder / "trackers/mine/data" / f"{name}.txt").write_text(results)
    rows = [f"{name} empty 000000 {FRAMES:06d}" for name in SEQUENCES]
    (folder / "evaluate_tracking.seqmap.training").write_text("\n".join(rows) + "\n")
    return folder


@pytest.mark.parametrize("kind", ["car", "pedestrian"])
def test_figures_are_those_of_trackevals_kitti(kind, folder, capsys):
    expected = by_trackeval(folder, kind)
    tracks = folder / "trackers/mine/data"
    assert main(["grade", "--truth", str(folder), "--tracks", str(tracks), "--kitti", kind, "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    for name, field in FIELDS.items():
        value = found["metrics"][f"track.{name}"]["value"]
        assert value == pytest.approx(float(np.mean(expected["COMBINED_SEQ"][field])), abs=1e-9), name
    for sequence_name in SEQUENCES:
        hota = found["scenes"][sequence_name]["track.hota"]
        assert hota == pytest.approx(float(np.mean(expected[sequence_name]["HOTA"])), abs=1e-9)
    assert found["metrics"]["track.gospa_m"]["reason"] == "boxes in the image have no metres"


def by_trackeval(folder, kind):
    """Return the figures of trackeval of each sequence and of both."""
    data = Kitti2DBox({"GT_FOLDER": str(folder), "TRACKERS_FOLDER": str(folder / "trackers"),
                       "CLASSES_TO_EVAL": [kind], "PRINT_CONFIG": False})  # fmt: skip
    limits = {"THRESHOLD": 0.5, "PRINT_CONFIG": False}
    quiet = ("PRINT_RESULTS", "PRINT_CONFIG", "TIME_PROGRESS", "OUTPUT_SUMMARY", "OUTPUT_DETAILED", "PLOT_CURVES")
    evaluator = Evaluator({**dict.fromkeys(quiet, False), "BREAK_ON_ERROR": True, "LOG_ON_ERROR": None})
    with redirect_stdout(StringIO()):
        results, _ = evaluator.evaluate([data], [HOTA(), CLEAR(limits), Identity(dict(limits))])
    found = results["Kitti2DBox"]["mine"]
    return {name: {key: value for part in found[name][kind].values() for key, value in part.items()} for name in found}


def test_other_limits_and_files_without_images_are_refused(folder, capsys):
    files = ["grade", "--truth", str(folder), "--tracks", str(folder / "trackers/mine/data")]
    assert main([*files, "--kitti", "car", "--range-max", "50"]) == 2
    assert "--kitti car: has the limits of the benchmark" in capsys.readouterr().err
    assert main([*files, "--kitti", "tram"]) == 2
    assert "--kitti tram: no class of KITTI's benchmark; give one of car, pedestrian" in capsys.readouterr().err
    csv = "docs/examples/boxes/truth.csv"
    assert main(["grade", "--truth", csv, "--tracks", csv, "--kitti", "car"]) == 2
    assert "truth.csv: has no boxes in the image, which --kitti grades" in capsys.readouterr().err
