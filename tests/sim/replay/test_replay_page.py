"""docs/own-scenario.md: table of columns, examples and figures match the code."""

import re

import numpy as np
import pandas as pd
import pytest
from support.pages import chapter
from support.paths import ROOT
from support.traffic import frames

from luxloop.scenarios.files.scenario import Scenario
from luxloop.sim.commonroad.commonroad_recording import STREET_HEIGHT
from luxloop.sim.replay.recording import KIND_BY_NAME
from luxloop.sim.replay.recording_files import read_recording
from luxloop.sim.replay.replay_source import ReplaySource
from luxloop.sim.replay.track_tables import OPTIONAL, REQUIRED
from luxloop.sim.replay.trajectories import FASTEST, JUMP
from luxloop.sim.world import Kind

PAGE = chapter("own-scenario.md", "Recorded traffic")
EXAMPLE = ROOT / "scenarios" / "catalog" / "urban" / "replayed-crossing.toml"
HIGHD, IND = re.findall(r"^```python\n(.*?)^```", PAGE, flags=re.DOTALL | re.MULTILINE)
TOML = re.findall(r"^```toml\n(.*?)^```", PAGE, flags=re.DOTALL | re.MULTILINE)


def test_the_table_of_columns_matches_the_code():
    rows = re.findall(r"^\| `(\w+)` \|[ \w]*\| (yes|no) \|", PAGE, flags=re.MULTILINE)
    assert sorted(name for name, needed in rows if needed == "yes") == sorted(REQUIRED)
    assert sorted(name for name, needed in rows if needed == "no") == sorted(OPTIONAL)
    (kinds,) = re.findall(r"^\| `kind` \| \| no \| (.*?), or a name", PAGE, flags=re.MULTILINE)
    assert re.findall(r"`([\w-]+)`", kinds) == list(KIND_BY_NAME)


def test_the_figures_match_the_code():
    assert f"({FASTEST:g} m/s plus\n  {JUMP:g} m)" in PAGE
    heights = ", ".join(f"{height:g}" for height in STREET_HEIGHT.values())
    assert f"({' and '.join(heights.rsplit(', ', 1))} m)" in PAGE


@pytest.mark.parametrize("block", TOML)
def test_examples_are_valid(block, tmp_path):
    path = tmp_path / "a.toml"
    path.write_text(f'description = "a"\nduration_s = 1\n{block}')
    assert Scenario.load(path).traffic.kind == "replay"


@pytest.fixture
def types(tmp_path):
    """Return the types in the page's example."""
    (block,) = (block for block in TOML if "truck_bus" in block)
    (tmp_path / "a.toml").write_text(f'description = "a"\nduration_s = 1\n{block}')
    return Scenario.load(tmp_path / "a.toml").traffic.types


def test_the_mapping_of_highd_gives_box_centres(tmp_path, monkeypatch, types):
    """A lorry drives left in the upper half of the image, a car right in the lower half; y points down."""
    monkeypatch.chdir(tmp_path)
    rows = {
        "frame": [25, 50],
        "id": [1, 2],
        "x": [100.0, 40.0],
        "y": [10.0, 30.0],
        "width": [12, 4],
        "height": [2.5, 2],
    }
    pd.DataFrame(rows).to_csv("01_tracks.csv", index=False)
    meta = {"id": [1, 2], "width": [12, 4], "class": ["Truck", "Car"], "drivingDirection": [1, 2]}
    pd.DataFrame(meta).to_csv("01_tracksMeta.csv", index=False)
    exec(compile(HIGHD, "own-scenario.md", "exec"), {})
    read = read_recording(tmp_path / "tracks.parquet", types)
    assert list(read.time) == [1.0, 2.0]
    assert read.pose == pytest.approx(np.array([[106.0, -11.25, np.pi], [42.0, -31.0, 0.0]]))
    assert [(user.kind, user.size[:2]) for user in read.users] == [(Kind.TRUCK, (12.0, 2.5)), (Kind.CAR, (4.0, 2.0))]


def test_the_mapping_of_ind_treats_zero_as_no_size(tmp_path, monkeypatch, types):
    monkeypatch.chdir(tmp_path)
    place = {"frame": [5, 5], "trackId": [7, 8], "xCenter": [1.0, 2.0], "yCenter": [-3.0, -4.0], "heading": [90.0, 0.0]}
    pd.DataFrame(place | {"width": [2.5, 0.0], "length": [9.0, 0.0]}).to_csv("00_tracks.csv", index=False)
    meta = {"trackId": [7, 8], "class": ["truck_bus", "pedestrian"]}
    pd.DataFrame(meta).to_csv("00_tracksMeta.csv", index=False)
    pd.DataFrame({"frameRate": [25.0]}).to_csv("00_recordingMeta.csv", index=False)
    exec(compile(IND, "own-scenario.md", "exec"), {})
    read = read_recording(tmp_path / "tracks.parquet", types)
    assert list(read.time) == [0.2, 0.2]
    assert read.pose == pytest.approx(np.array([[1.0, -3.0, np.pi / 2], [2.0, -4.0, 0.0]]))
    assert [user.kind for user in read.users] == [Kind.TRUCK, Kind.PEDESTRIAN]
    assert read.users[0].size[:2] == (9.0, 2.5)
    assert 0 < read.users[1].size[0] < 1


def test_the_shipped_recording_can_be_played_to_its_end():
    """Its ego waits, turns left, and leaves; the motion stays within a metre of SUMO's samples."""
    scenario = Scenario.load(EXAMPLE)
    source = ReplaySource(scenario.traffic, scenario.folder, 60.0)
    seen = frames(source, round(scenario.duration_s / source.dt))
    assert not seen[40].ego.velocity_world.any()
    turned = np.unwrap([frame.ego.pose_world[2] for frame in seen])
    assert np.degrees(turned[-1] - turned[0]) == pytest.approx(75.0, abs=5.0)
    assert min(len(frame.actors) for frame in seen) >= 2
    for frame in seen:
        assert np.abs(frame.actors.deviation[:, 0]).max() <= 1.0
        assert np.abs(frame.actors.deviation[:, 1]).max() <= 0.5
