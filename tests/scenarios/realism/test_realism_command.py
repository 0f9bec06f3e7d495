"""`luxloop realism`: from the data set of a run to table, JSON and figures."""

import json

import numpy as np
import pandas as pd
import pytest
from support import short_run

from luxloop.scenarios.cli import main
from luxloop.scenarios.realism import labelled_vehicle

REAL = """\
class,range_m,aspect_deg,front_seen,bow_end_m,std_about_faces_m,points_per_m_layer,best_error_deg
car,12,25,False,0.2,0.06,9,1.5
car,9,20,False,,0.05,12,0.5
car,9,20,True,0.1,0.07,,0.7
"""
BANDS = """\
face,from_m,to_m,lower_quartile_m,median_m,upper_quartile_m,vehicles
end,0.45,0.75,0.12,0.16,0.28,12
"""
MORE = """
[[traffic.actor]]
x_m = 13
y_m = -3
yaw_deg = 20
[[traffic.actor]]
x_m = -8
y_m = 5
yaw_deg = 160
"""
"""Intervals need at least three vehicles."""
BOXES = """
[noise]
ideal = true
layer_overlap.enabled = false
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A data set in `set`, of boxes without noise of the car, and tables of real vehicles."""
    made = tmp_path_factory.mktemp("realism")
    scenario = short_run.write(made, short_run.TEXT + MORE + BOXES)
    assert (
        main(["run", str(scenario), "--no-recording", "--out", str(made / "run"), "--dataset", str(made / "set")]) == 0
    )
    (made / "real.csv").write_text(REAL)
    (made / "bands.csv").write_text(BANDS)
    return made


def realism(folder, *options):
    return main(["realism", str(folder / "set"), "--real", str(folder / "real.csv"), *map(str, options)])


def printed(capsys, folder, *options):
    capsys.readouterr()
    assert realism(folder, *options, "--json") == 0
    return json.loads(capsys.readouterr().out)


def test_the_lidars_of_the_rig_are_in_the_summary(folder):
    """The shipped rig: six units at the edges of the ego, 4.83 m by 1.91 m, in the frame of its centre."""
    lidars = json.loads((folder / "set" / "summary.json").read_text())["lidars"]
    x, y = np.array([(unit["x_ego_m"], unit["y_ego_m"]) for unit in lidars]).T
    assert len(lidars) == 6
    assert 2.0 < x.max() < 2.5
    assert -2.5 < x.min() < -2.0
    assert sorted(np.sign(y).astype(int)) == [-1, -1, -1, 1, 1, 1]


def test_json_has_every_figure_with_interval_and_verdict(folder, capsys):
    found = printed(capsys, folder, "--real-bands", folder / "bands.csv")
    names = ["bow_end_0.45_0.75_m", "bow_end_m", "std_about_faces_m", "points_per_m_layer", "best_error_deg"]
    assert list(found["figures"]) == names
    assert found["real_vehicles"] == 3
    assert found["figures"]["bow_end_m"]["real"]["value"] == pytest.approx(0.15)
    assert found["figures"]["best_error_deg"]["average"] == "mean"
    assert set(found["differs"]) == {name for name in names if found["figures"][name]["verdict"] == "differs"}
    spread = found["figures"]["std_about_faces_m"]["simulated"]
    assert spread["interval"][0] <= spread["value"] <= spread["interval"][1]


def test_the_same_seed_gives_the_same_figures(folder, capsys):
    first, again, other, exact = (
        printed(capsys, folder, *options)["figures"]["best_error_deg"]["simulated"]["value"]
        for options in ([], [], ["--seed", 5], ["--label-sigma-deg", 0])
    )
    assert first == again
    assert first != other
    assert exact < first  # an error of 1.5 degrees in the labels adds to a fraction of a degree in the fits


def test_matched_vehicles_and_figures_are_written(folder, capsys):
    out = folder / "out"
    for _ in range(2):  # an earlier comparison is replaced
        assert realism(folder, "--real-bands", folder / "bands.csv", "--out", out) == 0
    shown = capsys.readouterr().out
    assert (out / "realism.txt").read_text().strip() in shown
    names = {"bow.png", "distributions.png", "matched.csv", "realism.json", "realism.txt", "vehicles.png"}
    assert {path.name for path in out.iterdir()} == names
    assert all((out / name).read_bytes().startswith(b"\x89PNG") for name in names if name.endswith("png"))
    matched = pd.read_csv(out / "matched.csv")
    assert matched.groupby("real_row").size().tolist() == [3, 3, 3]
    assert {"bow_end_m", "share_on_lines", "area_error_deg", "range_m", "front_seen"} <= set(matched)


def test_matched_vehicles_are_a_table_of_vehicles(folder, capsys):
    """Compared with its own matched vehicles, every figure of a simulation agrees."""
    out = folder / "own"
    assert realism(folder, "--label-sigma-deg", 0, "--out", out) == 0
    capsys.readouterr()
    own = ["realism", str(folder / "set"), "--real", str(out / "matched.csv"), "--label-sigma-deg", "0", "--json"]
    assert main(own) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["far_matches"] == 0
    assert found["differs"] == []


def test_mistakes_are_one_line(folder, capsys, tmp_path):
    (tmp_path / "mine").write_text("kept")
    mistakes = {
        ("--out", tmp_path): "holds no earlier comparison; choose another folder with --out",
        ("--real-bands", folder / "none.csv"): "does not exist",
        ("--label-sigma-deg", "-1"): "--label-sigma-deg",
        ("--real", folder / "set"): "is not a CSV file",
    }
    for options, message in mistakes.items():
        capsys.readouterr()
        assert realism(folder, *options) == 2
        streams = capsys.readouterr()
        assert streams.out == ""
        assert streams.err.count("\n") == 1
        assert message in streams.err
    assert main(["realism", str(folder / "run"), "--real", str(folder / "real.csv")]) == 2
    assert "has no scans.parquet; name a folder that luxloop run SCENARIO --dataset wrote" in capsys.readouterr().err


def test_one_unreadable_data_set_writes_nothing(folder, tmp_path):
    out = tmp_path / "out"
    assert realism(folder, folder / "run", "--out", out) == 2
    assert list(tmp_path.iterdir()) == []


def test_vehicles_are_those_of_all_data_sets(folder, capsys):
    count = len(labelled_vehicle.read(folder / "set", 0, 1.5, 0))
    assert printed(capsys, folder)["simulated_observations"] == count
    assert printed(capsys, folder, folder / "set")["simulated_observations"] == 2 * count
