"""OpenDRIVE files as nets of SUMO: the crossing through OpenDRIVE and back, and one-line errors."""

import re
import subprocess
import sys
from contextlib import closing
from pathlib import Path

import pytest
from support.paths import CATALOG

from luxloop.scenarios.errors import ScenarioError
from luxloop.scenarios.files.scenario import Scenario
from luxloop.sim.source import TrafficInputError
from luxloop.sim.sumo.input_checks import clean_up
from luxloop.sim.sumo.opendrive_net import _netconvert, _reason, converted
from luxloop.sim.sumo.sumo_config import SumoTraffic
from luxloop.sim.sumo.sumo_source import SumoSource

CROSSING = CATALOG / "urban" / "sumo-crossing"
EDGES = {"east": "50 51", "north": "52 53", "south": "54 55", "west": "56 57"}
"""Roads that netconvert makes of the edges into and out of the crossing, by arm."""


@pytest.fixture
def folder(tmp_path):
    """A folder with the crossing as OpenDRIVE, and its routes by the names after the conversion."""
    try:
        program, _ = _netconvert()
    except TrafficInputError:
        pytest.skip("eclipse-sumo is not installed")
    net, xodr = CROSSING / "crossing.net.xml", tmp_path / "crossing.xodr"
    subprocess.run([program, "-s", net, "--opendrive-output", xodr], check=True, capture_output=True)
    routes = (CROSSING / "crossing.rou.xml").read_text(encoding="utf-8").replace('departLane="1"', 'departLane="0"')
    for arm, roads in EDGES.items():
        for way, road in zip(("in", "out"), roads.split(), strict=True):
            routes = routes.replace(f"{arm}_{way}", f"-{road}")
    (tmp_path / "crossing.rou.xml").write_text(routes, encoding="utf-8")
    yield tmp_path
    clean_up()


def vehicle_lanes(text):
    """Return widths of the lanes outside junctions that vehicles may use."""
    lanes = re.findall(r'<lane id="[^:"][^>]*>', text)
    return sorted(re.search(r'width="([\d.]+)"', lane)[1] for lane in lanes if ' allow="pedestrian"' not in lane)


def test_all_lanes_of_vehicles_return_through_opendrive(folder):
    nets = (CROSSING / "crossing.net.xml", Path(converted(folder, "crossing.xodr", {})))
    assert [vehicle_lanes(net.read_text(encoding="utf-8")) for net in nets] == [["3.25"] * 16] * 2


def test_traffic_drives_on_the_converted_net(folder):
    keys = {"net": "crossing.xodr", "routes": ["crossing.rou.xml"], "ego": "vehicle:ego"}
    with closing(SumoSource(SumoTraffic(**keys, netconvert={"tls.cycle.time": "70"}), folder, 100.0)) as source:
        source.reset(1)
        first = source.step()
    # on the south arm, 110 m before the stop line, in the right-hand lane for vehicles
    assert first.ego.pose_world[:2] == pytest.approx([-4.6, -130], abs=3)
    assert len(first.actors) > 5


def test_a_broken_file_is_refused_in_one_line(folder):
    (folder / "broken.xodr").write_text("<OpenDRIVE><road>", encoding="utf-8")
    with pytest.raises(TrafficInputError, match=r'net = "broken\.xodr": netconvert cannot convert it: ') as error:
        converted(folder, "broken.xodr", {})
    assert "\n" not in str(error.value)


@pytest.mark.parametrize(
    ("stderr", "reason"),
    [
        (
            "Error: While processing option 'tls.cycle.time':\n 'abc' is not a valid integer.\n"
            "Error: Could not parse commandline options.\nQuitting (on error).\n",
            "While processing option 'tls.cycle.time': 'abc' is not a valid integer.",
        ),
        (
            "Warning: no header\nError: unexpected end of input\n In file 'a.xodr'\n At line/column 2/52.\n\n"
            "Error: No nodes loaded.\n",
            "unexpected end of input In file 'a.xodr' At line/column 2/52.",
        ),
        ("Error: No nodes loaded.\nQuitting (on error).\n", "No nodes loaded."),
        ("Segmentation fault\n", "Segmentation fault"),
        ("", "no message"),
    ],
)
def test_the_reason_of_netconvert_contains_the_cause(stderr, reason):
    assert _reason(stderr) == reason


def test_a_missing_netconvert_names_the_extra(tmp_path, monkeypatch):
    (tmp_path / "a.xodr").write_text("<OpenDRIVE/>", encoding="utf-8")
    monkeypatch.setitem(sys.modules, "sumo", None)
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(TrafficInputError, match=r"not installed: pip install 'eclipse-sumo.*>=1\.28"):
        converted(tmp_path, "a.xodr", {})


def test_a_missing_file_and_options_that_write_files_are_refused(tmp_path):
    with pytest.raises(TrafficInputError, match=r'net = "a\.xodr": no such file'):
        converted(tmp_path, "a.xodr", {})
    (tmp_path / "folder.xodr").mkdir()
    with pytest.raises(TrafficInputError, match=r'net = "folder\.xodr": is a folder; name a file in it'):
        converted(tmp_path, "folder.xodr", {})
    (tmp_path / "a.xodr").write_text("<OpenDRIVE/>", encoding="utf-8")
    for option in ("output-prefix", "opendrive-output", "osm-files", "save-configuration"):
        with pytest.raises(TrafficInputError, match=rf"netconvert\.{option}: options that name files"):
            converted(tmp_path, "a.xodr", {option: "x"})


def test_options_of_netconvert_need_an_opendrive_net(tmp_path):
    path = tmp_path / "a.toml"
    path.write_text(
        'description = "d"\nduration_s = 1.0\n[traffic]\nkind = "sumo"\nnet = "a.net.xml"\nroutes = ["a.rou.xml"]\n'
        'netconvert = { "tls.cycle.time" = "70" }\n',
        encoding="utf-8",
    )
    with pytest.raises(ScenarioError, match="netconvert requires an OpenDRIVE net"):
        Scenario.load(path)
