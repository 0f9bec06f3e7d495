"""Rectangles in files against true boxes: by hand, and with the figures of a run."""

import json

import numpy as np
import pytest
from support import box_files, exported_run

from luxloop.scenarios.cli import main
from luxloop.scenarios.run import run_folder

HEAD = "x_m,y_m,heading_rad,length_m,width_m"
TRUTH = f"frame,id,{HEAD}\n0,a,10,5,0,4,2\n0,b,30,5,0,4,2\n1,a,10,5,0,4,2\n"
"""The nearest corner of car a is (8, 4)."""
FIGURES = [
    f"fit.{name}"
    for name in ("heading_mean_deg", "heading_std_deg", "heading_abs_mean_deg", "position_abs_mean_m", "iou_mean")
]
EGO = "x_ego_m,y_ego_m,heading_ego_rad,length_m,width_m"


def about_the_corner(degrees):
    """Car a turned about its nearest corner."""
    angle = float(np.radians(degrees))
    cos, sin = float(np.cos(angle)), float(np.sin(angle))
    return f"{8 + 2 * cos - sin!r},{4 + 2 * sin + cos!r},{angle!r},4,2"


FITS = "\n".join(
    [
        f"frame,method,{HEAD}",
        f"0,turned,{about_the_corner(2.0)}",
        f"1,turned,{about_the_corner(-4.0)}",
        f"0,moved,10.3,5,{np.pi / 2!r},2,4",  # the same rectangle, named by its other side
        "1,moved,10,4.6,0,4,2",
        "0,moved,60,5,0,4,2",
    ]
)


def graded(capsys, *words):
    assert main(["grade", *map(str, words), "--json"]) == 0
    return json.loads(capsys.readouterr().out)


def test_figures_by_hand(tmp_path, capsys):
    """Headings of 2 and -4 degrees; gaps of 0.3 and 0.4 m, with overlaps of 3.7 x 2 and 4 x 1.6 of twice 8 m^2."""
    a, b = box_files.write(tmp_path, "a.csv", TRUTH), box_files.write(tmp_path, "b.csv", FITS)
    found = graded(capsys, "--truth", a, "--fits", b)["fits"]
    assert (found["fits"], found["on_no_true_box"]) == (5, 1)
    values = {method: [row[name]["value"] for name in FIGURES] for method, row in found["methods"].items()}
    assert values["turned"][:4] == pytest.approx([-1.0, 3.0, 3.0, 0.0], abs=1e-9)
    assert values["moved"] == pytest.approx([0.0, 0.0, 0.0, 0.35, (7.4 / 8.6 + 6.4 / 9.6) / 2], abs=1e-9)
    assert [row["fit.iou_mean"]["n"] for row in found["methods"].values()] == [2, 2]


def test_a_fit_on_a_box_outside_a_limit_is_left_out(tmp_path, capsys):
    counted = "\n".join(f"{row},{points}" for row, points in zip(TRUTH.split(), ("points", 9, 9, 2), strict=True))
    a, b = box_files.write(tmp_path, "a.csv", counted), box_files.write(tmp_path, "b.csv", FITS)
    found = graded(capsys, "--truth", a, "--fits", b, "--points-min", "3")["fits"]["methods"]
    assert found["turned"]["fit.heading_mean_deg"]["value"] == pytest.approx(2.0)
    assert found["moved"]["fit.position_abs_mean_m"]["value"] == pytest.approx(0.3)


def test_fits_and_tracks_are_graded_together_and_printed(tmp_path, capsys):
    a, b = (
        box_files.write(tmp_path, "a.csv", TRUTH),
        box_files.write(tmp_path, "b.csv", FITS.replace("method", "kind2")),
    )
    both = graded(capsys, "--truth", a, "--tracks", a, "--fits", b)
    assert both["metrics"]["track.hota"]["value"] == 1.0
    assert both["fits"]["methods"]["all"]["fit.heading_abs_mean_deg"]["n"] == 4
    assert main(["grade", "--truth", str(a), "--fits", str(b)]) == 0
    assert "5 fits, 1 of them on no true box" in capsys.readouterr().out


def test_nearest_corners_are_unknown_in_world_axes(tmp_path, capsys):
    world = [text.replace(HEAD, EGO.replace("ego", "world")) for text in (TRUTH, FITS)]
    a, b = (box_files.write(tmp_path, name, text) for name, text in zip(("a.csv", "b.csv"), world, strict=True))
    found = graded(capsys, "--truth", a, "--fits", b)["fits"]["methods"]["turned"]
    assert found["fit.position_abs_mean_m"]["value"] is None
    assert found["fit.position_abs_mean_m"]["reason"].startswith("the positions are not about the ego")
    assert found["fit.heading_std_deg"]["value"] == pytest.approx(3.0)


def test_fits_of_a_run_have_its_figures(tmp_path, capsys):
    """The table of fits of the run, whose rectangles are all on their vehicles in this scene."""
    import pandas as pd

    run = exported_run.recorded(tmp_path)
    fits = pd.read_parquet(run / "tables" / "fits.parquet")
    fits = fits[np.isfinite(fits["heading_ego_rad"])]
    fits.to_parquet(tmp_path / "fits.parquet")
    capsys.readouterr()
    found = graded(capsys, "--truth", run / "scans" / "labels.parquet", "--fits", tmp_path / "fits.parquet")["fits"]
    expected = run_folder.read(run).metrics
    assert set(found["methods"]) == {"area", "closeness", "variance", "tlinkage", "refined"}
    for method, figures in found["methods"].items():
        for name in FIGURES:
            metric = figures[name]
            of_run = expected[f"{name}{{method={method}}}"]
            assert (metric["value"], metric["n"]) == (pytest.approx(of_run.value, abs=1e-6), of_run.n), name


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--fits", "b.csv"], "give RUN, or both of --truth FILE and --tracks FILE"),
        (["run", "--fits", "b.csv"], "--fits cannot be given with RUN; give either RUN"),
        (["--truth", "a.csv", "--fits", "c.txt"], "c.txt: is of the format kitti; give fits as CSV or Parquet"),
        (["--truth", "a.csv", "--fits", "d.csv"], "d.csv: column method, row 1: an empty cell: give the name of"),
        (["--truth", "a.csv", "--fits", "e.csv"], "e.csv: has no frame in common with a.csv"),
    ],
)
def test_an_invalid_request_is_refused_in_one_line(words, message, tmp_path, monkeypatch, capfd):
    monkeypatch.chdir(tmp_path)
    files = {
        "a.csv": TRUTH, "b.csv": FITS, "c.txt": "", "d.csv": f"frame,method,{HEAD}\n0,,1,2,0,4,2\n",
        "e.csv": f"frame,{HEAD}\n7,1,2,0,4,2\n",
    }  # fmt: skip
    for name, text in files.items():
        box_files.write(tmp_path, name, text)
    assert main(["grade", *words]) == 2
    error = capfd.readouterr().err
    assert error.startswith(f"luxloop: error: {message}")
    assert error.count("\n") == 1
