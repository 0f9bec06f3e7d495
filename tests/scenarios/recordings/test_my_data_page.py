"""docs/recordings.md: each command of the table "my data" runs on files of the names in it."""

import re
import shlex
import shutil

import numpy as np
import pandas as pd
import pytest
from support import exported_run
from support import recorded_drive as drive
from support.av2_log import write_av2
from support.paths import DOCS, EXAMPLES

from luxloop.scenarios.cli import main

TABLE = (DOCS / "recordings.md").read_text(encoding="utf-8").partition("| I have |")[2].partition("\n\n")[0]
COMMANDS = [shlex.split(text)[1:] for text in re.findall(r"`(luxloop [^`]* [^`]*\w)`", TABLE)]
WITH_TRUTH = {"boxes.csv", "/car=4.5,1.8", "nuscenes", "av2", "kitti", "labels.parquet"}
"""Words of imports whose recordings have true boxes."""


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    """A folder with all files and folders that the commands name."""
    folder = tmp_path_factory.mktemp("data")
    drive.write_ros1(folder / "drive.bag")
    time = drive.times()
    car = np.array([drive.car_pose(one) - drive.ego_pose(one) for one in time])
    columns = {"time_s": time, "id": "car", "x_ego_m": car[:, 1], "y_ego_m": -car[:, 0]}
    boxes = pd.DataFrame({**columns, "heading_ego_rad": 0.0, "length_m": 4.5, "width_m": 1.8})
    boxes.to_csv(folder / "boxes.csv", index=False)
    run = exported_run.recorded(folder)
    for kind in ("nuscenes", "kitti"):
        assert main(["export", str(run), "--format", kind, "--out", str(folder / kind)]) == 0
    write_av2(run, folder / "av2", ground_m=-0.3)
    for name in ("points", "scans", "labels"):
        shutil.copy(run / "scans" / f"{name}.parquet", folder)
    track = {"track_id": 0, "x_odom_m": 9.0, "y_odom_m": 3.0, "heading_odom_rad": 0.0, "length_m": 4.8, "width_m": 1.8}
    pd.DataFrame([{"frame": frame, **track} for frame in range(10)]).to_csv(folder / "tracks.csv", index=False)
    return folder


@pytest.mark.slow
def test_every_command_of_the_table_runs(files, monkeypatch, capsys):
    """In the order of the table: `recorded` is that of the last import, and only `track` gets an option of the test."""
    monkeypatch.chdir(files)
    assert [words[0] for words in COMMANDS] == ["import", "track", *["import"] * 6, "grade", "grade"]
    for words in COMMANDS[:-1]:
        assert main([*words, "--no-recording"] if words[0] == "track" else words) == 0, words
        if words[0] == "import":
            assert (files / "recorded" / "labels.parquet").exists() == bool(WITH_TRUTH & set(words)), words
    assert "HOTA" in capsys.readouterr().out
    for name, source in (("truth.csv", "truth.csv"), ("boxes.csv", "tracks.csv")):
        shutil.copy(EXAMPLES / "boxes" / source, files / name)
    assert main(COMMANDS[-1]) == 0
    assert "track.hota" in capsys.readouterr().out
