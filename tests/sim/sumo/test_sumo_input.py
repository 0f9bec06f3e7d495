"""SUMO's command line and errors: no output beside the input, precedence of options, errors of one line."""

import gzip
import hashlib

import libsumo
import numpy as np
import pytest
from support.paths import NETS

from luxloop.sim.source import TrafficInputError
from luxloop.sim.sumo.error_messages import captured_stderr, one_line
from luxloop.sim.sumo.input_checks import input_files, is_left_hand, sumo_command
from luxloop.sim.sumo.options import is_rejected
from luxloop.sim.sumo.roadside import static_obstacles

NET = NETS / "winding" / "winding.net.xml"
PROJECTED = NETS / "spreewaldring" / "spreewaldring.net.xml"
ROUTE = '<route id="r" edges="start r80"/><vehicle id="v" route="r" depart="0"/>'


@pytest.fixture
def folder(tmp_path):
    """Return a folder with a net, a route file, an additional file and a configuration of them."""
    (tmp_path / "a.net.xml").write_bytes(NET.read_bytes())
    (tmp_path / "a.rou.xml").write_text(f"<routes>{ROUTE}</routes>")
    (tmp_path / "a.add.xml").write_text("<additional/>")
    configure(tmp_path)
    yield tmp_path
    if libsumo.isLoaded():
        libsumo.close()


def configure(folder, more="", net="a.net.xml"):
    (folder / "a.sumocfg").write_text(f"""<sumoConfiguration>
        <input><net-file value="{net}"/><route-files value="a.rou.xml"/><additional-files value="a.add.xml"/></input>
        {more}</sumoConfiguration>""")


def command(folder, options=None, begin_s=None, **files):
    files = {name.replace("_", "-"): names for name, names in files.items()} or {"configuration-file": ["a.sumocfg"]}
    return sumo_command(folder, files, 0.5, 7, options or {}, begin_s)


def option(name):
    return libsumo.simulation.getOption(name)


def run(folder, steps=40, **keys):
    libsumo.start(command(folder, **keys))
    for _ in range(steps):
        libsumo.simulationStep()


def rejection(folder, **keys):
    with pytest.raises(TrafficInputError) as caught:
        command(folder, **keys)
    assert "\n" not in str(caught.value)
    return str(caught.value)


def error_message(folder, routes=ROUTE, additional=""):
    """Return the one-line message for SUMO's error about these files."""
    (folder / "a.rou.xml").write_text(f"<routes>{routes}</routes>")
    (folder / "a.add.xml").write_text(f"<additional>{additional}</additional>")
    arguments = command(folder)
    with captured_stderr() as captured:
        try:
            libsumo.start(arguments)
            for _ in range(4):
                libsumo.simulationStep()
        except (libsumo.TraCIException, libsumo.FatalTraCIError) as error:
            captured.seek(0)
            line = one_line(captured.read().decode() or str(error), arguments)
        else:
            pytest.fail("SUMO raised no error")
    assert "\n" not in line
    return line


# ---- no output

OUTPUTS = """<output>
    <fcd-output value="fcd.xml"/><summary value="summary.xml"/><tripinfo-output value="tripinfo.xml"/>
    <netstate-dump value="dump.xml"/><vtk-output value="vtk"/><full-output value="full.xml"/>
    <vehroute-output value="routes.xml"/><emission-output value="emission.xml"/><queue-output value="queue.xml"/>
    <amitran-output value="amitran.xml"/><lanechange-output value="changes.xml"/><stop-output value="stops.xml"/>
    <statistic-output value="statistic.xml"/><collision-output value="collisions.xml"/>
    <edgedata-output value="edges.xml"/><link-output value="links.xml"/><output-prefix value="TIME_"/>
    <save-state.times value="2,4"/><save-state.prefix value="state"/></output>
    <report><log value="log.txt"/><message-log value="messages.txt"/><error-log value="errors.txt"/>
    <verbose value="true"/><print-options value="true"/><duration-log.statistics value="true"/></report>"""
DETECTORS = """<inductionLoop id="a" lane="start_0" pos="50" period="5" file="../loop.xml"/>
    <instantInductionLoop id="b" lane="start_0" pos="60" file="instant.xml"/>
    <laneAreaDetector id="c" lane="start_0" pos="10" length="30" period="5" file="area.xml"/>
    <edgeData id="d" period="5" file="edge.xml"/><laneData id="e" file="lane.xml"/>
    <vTypeProbe id="f" type="DEFAULT_VEHTYPE" period="1" file="probe.xml"/>
    <routeProbe id="g" edge="start" period="5" file="deep/route.xml"/>"""
SSM = """<vType id="t"><param key="has.ssm.device" value="true"/></vType>
    <vType id="u"><param key="has.ssm.device" value="true"/><param key="device.ssm.file" value="ssm.xml"/></vType>
    <vehicle id="s" type="t" route="r" depart="1"/><vehicle id="u" type="u" route="r" depart="2"/>"""


def listing(folder):
    return {path: hashlib.sha256(path.read_bytes()).hexdigest() for path in folder.rglob("*") if path.is_file()}


def test_configured_outputs_are_not_written(folder, monkeypatch, capfd):
    inner = folder / "scenario"
    (inner / "deep").mkdir(parents=True)
    for name in ("a.net.xml", "a.rou.xml", "a.add.xml"):
        (folder / name).rename(inner / name)
    configure(inner, OUTPUTS)
    (inner / "a.add.xml").write_text(f"<additional>{DETECTORS}</additional>")
    (inner / "a.rou.xml").write_text(f"<routes>{ROUTE}{SSM}</routes>")
    monkeypatch.chdir(folder)
    before = listing(folder)
    run(inner, 20)
    assert set(libsumo.vehicle.getIDList()) == {"v", "s", "u"}
    libsumo.close()
    assert listing(folder) == before
    assert capfd.readouterr().out == ""


def test_output_options_are_removed_from_the_command(folder):
    configure(folder, OUTPUTS)
    arguments = " ".join(command(folder))
    assert not any(name in arguments for name in ("fcd", "summary", "dump", "save-state", "log.txt", "print-options"))


@pytest.mark.parametrize("name", ["fcd-output", "summary", "log", "save-state.times", "remote-port", "device.ssm.file"])
def test_output_and_interactive_options_of_a_scenario_are_rejected(folder, name):
    assert is_rejected(name)
    assert f"options.{name}: " in rejection(folder, options={name: "x"})


def test_options_of_the_traffic_are_kept():
    assert not any(
        is_rejected(name)
        for name in (
            "lateral-resolution", "time-to-teleport", "collision.action", "device.rerouting.probability", "scale",
            "device.fcd.probability", "lanechange.duration", "step-method.ballistic", "load-state", "begin", "end",
            "default.speeddev", "device.ssm.probability", "game-like-vehicles",
        )
    )  # fmt: skip


# ---- precedence


def test_fixed_options_override_the_configuration(folder):
    configure(
        folder,
        """<time><begin value="3"/><end value="5"/><step-length value="1"/></time>
        <random_number><seed value="99"/><random value="true"/></random_number>
        <processing><lateral-resolution value="0.4"/><collision.action value="warn"/></processing>
        <traci_server><remote-port value="8813"/></traci_server>
        <gui_only><gui-settings-file value="gone.view.xml"/><start value="true"/></gui_only>""",
    )
    run(folder, options={"collision.action": "none"})
    assert (option("step-length"), option("seed"), option("random")) == ("0.5", "7", "false")
    assert (option("lateral-resolution"), option("collision.action")) == ("0.4", "none")
    assert option("remote-port") == "0", "SUMO would wait for a client forever"
    assert float(option("begin")) == 3.0
    assert libsumo.simulation.getTime() == 3.0 + 40 * 0.5, "the end time of the configuration must not stop the run"
    libsumo.close()
    run(folder, begin_s=4.0)
    assert libsumo.simulation.getTime() == 4.0 + 40 * 0.5


def test_synonyms_of_options_are_known(folder):
    (folder / "a.sumocfg").write_text(
        '<configuration><n v="a.net.xml"/><r v="a.rou.xml"/><b v="2"/><srand v="3"/></configuration>'
    )
    run(folder, 2, options={"b": "5"})
    assert (libsumo.simulation.getTime(), option("seed")) == (6.0, "7")


def test_paths_are_relative_to_the_configuration_and_may_use_variables(folder, monkeypatch):
    (folder / "cfg").mkdir()
    (folder / "cfg" / "b.sumocfg").write_text("""<configuration><input><net-file value="${HERE}/a.net.xml"/>
        <route-files value="../a.rou.xml, ../b.rou.xml"/></input></configuration>""")
    (folder / "b.rou.xml").write_text('<routes><vehicle id="w" route="r" depart="0"/></routes>')
    monkeypatch.setenv("HERE", str(folder))
    arguments = command(folder, configuration_file=["cfg/b.sumocfg"])
    assert [path.resolve() for path in input_files(arguments)] == [folder / "a.rou.xml", folder / "b.rou.xml"]
    run(folder, 12, configuration_file=["cfg/b.sumocfg"])
    assert set(libsumo.vehicle.getIDList()) == {"v", "w"}


def test_compressed_files_are_read(folder):
    for name in ("a.net.xml", "a.rou.xml", "a.add.xml"):
        (folder / f"{name}.gz").write_bytes(gzip.compress((folder / name).read_bytes()))
    files = {"net_file": ["a.net.xml.gz"], "route_files": ["a.rou.xml.gz"], "additional_files": ["a.add.xml.gz"]}
    run(folder, 4, **files)
    assert libsumo.vehicle.getIDList() == ("v",)


def test_the_side_of_traffic_is_read_from_the_net(folder):
    assert not is_left_hand(command(folder))
    assert is_left_hand(command(folder, net_file=[str(NETS / "left-hand" / "left-hand.net.xml")]))
    assert not is_left_hand(command(folder, net_file=[str(NETS / "grid" / "grid.net.xml.gz")]))


# ---- errors


@pytest.mark.parametrize("name", ["a.net.xml", "a.rou.xml", "a.add.xml"])
def test_a_missing_file_of_a_configuration_is_an_error(folder, name):
    (folder / name).unlink()
    assert f"{folder / name}: no such file; " in rejection(folder)


def test_a_mesoscopic_configuration_is_rejected(folder):
    configure(folder, '<processing><mesosim value="true"/></processing>')
    assert "mesosim" in rejection(folder)


def test_a_corrupt_archive_is_rejected(folder):
    (folder / "a.net.xml").write_bytes(gzip.compress(NET.read_bytes())[:400])
    assert "is not valid XML" in rejection(folder)


@pytest.mark.parametrize(
    ("routes", "additional", "expected"),
    [
        (
            '<route id="r" edges="start nowhere"/>',
            "",
            "a.rou.xml: The edge 'nowhere' within the route 'r' is not known. The route can not be build; "
            "name an edge of the net",
        ),
        (ROUTE + '<vehicle id="w" type="blimp" route="r" depart="0"/>', "", "a.rou.xml: The vehicle type 'blimp' for "),
        ('<vehicle id="w" route="gone" depart="0"/>', "", "a.rou.xml: The route 'gone' for vehicle 'w' is not known; "),
        ('<vehicle id="w" depart="0"><route edges="start r40"/></vehicle>', "", "connected one to the next"),
        ('<trip id="w" from="hairpin" to="start" depart="0"/>', "", "connected one to the next"),
        (ROUTE + '<vehicle id="v" route="r" depart="0"/>', "", "Another vehicle with the id 'v' exists; use unique"),
        ("<vehicle", "", "a.rou.xml"),
        (ROUTE, '<include href="gone.xml"/>', "gone.xml"),
        (ROUTE, '<parkingArea id="p" lane="gone_0"/>', "gone_0"),
        (ROUTE, '<inductionLoop id="l" lane="start_0" pos="5" period="5" file="gone/l.xml"/>', "; create the folder"),
        (ROUTE, '<poi id="p" type="tree" lon="11" lat="48"/>', "; write x and y of the net"),
    ],
)
def test_an_error_is_one_line_with_file_and_remedy(folder, routes, additional, expected):
    assert expected in error_message(folder, routes, additional)


def test_a_begin_after_the_configuration_s_end_is_an_error(folder):
    configure(folder, '<time><end value="5"/></time>')
    arguments = command(folder, begin_s=10.0)
    with captured_stderr() as captured:
        with pytest.raises(libsumo.TraCIException):
            libsumo.start(arguments)
        captured.seek(0)
        line = one_line(captured.read().decode(), arguments)
    assert line == "The end time should be after the begin time; lower begin_s, or set options.end"


def test_an_error_names_no_file_if_several_match(folder):
    (folder / "b.rou.xml").write_text("<routes>nowhere r</routes>")
    arguments = command(folder, net_file=["a.net.xml"], route_files=["a.rou.xml", "b.rou.xml"])
    (folder / "a.rou.xml").write_text("nowhere r")
    line = one_line("Error: The edge 'nowhere' within the route 'r' is not known.\nError: Quitting.", arguments)
    assert line == "The edge 'nowhere' within the route 'r' is not known; name an edge of the net"
    line = one_line("Error: The busStop 'shops' is not known in vehicle 'bus'.")
    assert line == "The busStop 'shops' is not known in vehicle 'bus'; list the file that defines it under additional"


def test_polygons_in_degrees_need_the_net_s_projection(folder):
    # 1/1000 of a degree of latitude is 111.2 m, of longitude at 52 degrees north 68.7 m
    (folder / "a.add.xml").write_text("""<additional><poly id="b" type="building" geo="1"
        shape="13.685,51.997 13.686,51.997 13.686,51.998"/></additional>""")
    message = rejection(folder)
    assert message.startswith(f"{folder / 'a.add.xml'}: ")
    assert "no projection" in message
    (folder / "a.rou.xml").write_text("<routes/>")
    run(folder, 1, net_file=[str(PROJECTED)], additional_files=["a.add.xml"])
    corners = static_obstacles(libsumo.polygon, libsumo.poi, 10.0).vertices_world
    assert np.hypot(*np.diff(corners, axis=0).T) == pytest.approx([68.7, 111.2], abs=0.3)


# ---- polygons written by polyconvert


def obstacles_of(folder, shapes):
    (folder / "a.add.xml").write_text(f"<additional>{shapes}</additional>")
    run(folder, 1)
    return static_obstacles(libsumo.polygon, libsumo.poi, 10.0)


def poly(kind, shape="0,0 9,0 9,9 9,9 0,9 0,0", **parameters):
    inside = "".join(f'<param key="{key}" value="{value}"/>' for key, value in parameters.items())
    return (
        f'<poly id="{poly.count()}" type="{kind}" color="1,.9,.9" fill="1" layer="-1" shape="{shape}">{inside}</poly>'
    )


poly.count = iter(range(1000)).__next__


@pytest.mark.parametrize(
    "kind", ["landuse.grass", "amenity.parking", "parking", "natural.water", "leisure.park", "unknown"]
)
def test_flat_polygons_are_not_obstacles(folder, kind):
    assert len(obstacles_of(folder, poly(kind))) == 0


def test_repeated_and_closing_corners_are_removed(folder):
    found = obstacles_of(folder, poly("building.residential"))
    assert found.vertices_world.tolist() == [[0, 0], [9, 0], [9, 9], [0, 9]]


@pytest.mark.parametrize(
    ("parameters", "height"),
    [
        ({}, 10.0),
        ({"height": "7.5"}, 7.5),
        ({"height": "7 m"}, 7.0),
        ({"building:levels": "4"}, 12.0),
        ({"building:levels": "4", "height": "13"}, 13.0),
    ],
)
def test_heights_follow_openstreetmap_s_tags(folder, parameters, height):
    assert list(obstacles_of(folder, poly("building", **parameters)).height) == [height]


def test_degenerate_buildings_at_the_edge_of_an_extract_are_ignored(folder):
    assert len(obstacles_of(folder, poly("building", "3,3") + poly("building", "3,3 3,3"))) == 0
