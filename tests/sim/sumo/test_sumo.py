"""SUMO: conventions, errors, and properties of the two SUMO scenarios."""

import gzip
import xml.etree.ElementTree as ET
from contextlib import closing
from dataclasses import replace

import numpy as np
import pytest
from support.paths import CATALOG
from support.traffic import frames, play

from luxloop.scenarios.files.scenario import Scenario
from luxloop.sim.source import SimulatorFailedError, TrafficEndedError, TrafficInputError
from luxloop.sim.sumo.sumo_config import SumoTraffic
from luxloop.sim.sumo.sumo_source import SumoSource
from luxloop.sim.sumo.vehicles import kind_of_shape
from luxloop.sim.world import Kind

CROSSING = CATALOG / "urban" / "sumo-crossing"
NET = CROSSING / "crossing.net.xml"

EASTBOUND = """<route id="east" edges="west_in east_out"/>
<vehicle id="first" route="east" depart="0" departPos="60" departLane="1" departSpeed="0"/>
<vehicle id="second" route="east" depart="3" departSpeed="0"/>"""


@pytest.fixture
def sumo(tmp_path):
    """Return a factory of sources on the crossing's net, given the content of a route file; close them afterwards."""
    made = []

    def make(traffic=EASTBOUND, *, range_m=100.0, **keys):
        (tmp_path / "traffic.rou.xml").write_text(f"<routes>{traffic}</routes>")
        keys = {"net": str(NET), "routes": ["traffic.rou.xml"]} | keys
        made.append(SumoSource(SumoTraffic(**keys), tmp_path, range_m))
        return made[-1]

    yield make
    for source in made:
        source.close()


def lane_point(lane_id, distance):
    """Return point and direction on a straight lane of the net file, `distance` [m] from its start."""
    (lane,) = [lane for lane in ET.parse(NET).getroot().iter("lane") if lane.get("id") == lane_id]
    start, end = (np.array([float(v) for v in point.split(",")]) for point in lane.get("shape").split())
    along = (end - start) / np.linalg.norm(end - start)
    return start + along * distance * np.linalg.norm(end - start) / float(lane.get("length")), along


# ---- poses, sizes, kinds


@pytest.mark.parametrize(
    ("shape", "height", "kind"),
    [
        ("passenger/sedan", 1.45, Kind.CAR),
        ("passenger", 1.67, Kind.SUV),
        ("taxi", 1.5, Kind.CAR),
        ("passenger/van", 1.8, Kind.VAN),
        ("delivery", 2.6, Kind.VAN),
        ("truck", 3.4, Kind.TRUCK),
        ("truck/semitrailer", 4.0, Kind.TRAILER_TRUCK),
        ("bus/flexible", 3.0, Kind.BUS),
        ("motorcycle", 1.5, Kind.MOTORCYCLE),
        ("bicycle", 1.7, Kind.BICYCLE),
        ("unknown/shape", 1.5, Kind.CAR),
    ],
)
def test_kinds_by_shape(shape, height, kind):
    assert kind_of_shape(shape, height) is kind


def test_pedestrians_are_delivered_and_distinct_from_vehicles_of_the_same_name(sumo):
    walkers = """<person id="second" depart="0" departPos="55"><walk edges="west_in east_out"/></person>
    <person id="far" depart="0" departPos="5"><walk edges="north_in north_out"/></person>"""
    rider = '<person id="rider" depart="triggered"><ride from="west_in" to="east_out" lines="first"/></person>'
    route, first, second = EASTBOUND.splitlines()
    seen = frames(sumo("\n".join([route, walkers, first, rider, second]), range_m=120.0), 60)
    on_foot = {
        (str(actors.name[row]), float(actors.size[row, 2]))
        for actors in (frame.actors for frame in seen)
        for row in np.flatnonzero(actors.kind == Kind.PEDESTRIAN)
    }
    assert [name for name, _ in on_foot] == ["second"]
    assert all(1.55 <= height <= 1.90 for _, height in on_foot)  # random size instead of SUMO's default of 1.719 m
    namesakes = {int(number) for frame in seen for number in frame.actors.id[frame.actors.name == "second"]}
    assert len(namesakes) == 2, "the vehicle and the person of that name have different numbers"


def test_actors_that_appear_together_are_numbered_by_name():
    """Fails if the order depends on hashes of the names, which differ between processes."""
    scenario = Scenario.load(CATALOG / "urban" / "sumo-crossing.toml")
    with closing(SumoSource(scenario.traffic, scenario.folder, 150.0)) as source:
        source.reset(1)
        names = list(source.step().actors.name)
    assert len(names) > 20
    assert names == sorted(names)


# ---- obstacles


def test_buildings_and_shapes_with_a_height_are_obstacles(sumo, tmp_path):
    (tmp_path / "shapes.add.xml").write_text("""<additional>
        <poly id="b" type="building.garage" shape="0,0 4,0 4,3 0,0"/>
        <poly id="a" type="wall" shape="10,0 20,0"><param key="height" value="2.5"/></poly>
        <poly id="c" type="lawn" shape="0,0 4,0 4,3"/></additional>""")
    obstacles = sumo(additional=["shapes.add.xml"], building_height_m=6.0).reset(0)
    assert obstacles.height == pytest.approx([2.5, 6.0])  # sorted by name; the lawn is not an obstacle
    assert list(obstacles.offset) == [0, 2, 5]  # without the closing corner
    assert obstacles.vertices_world[2:] == pytest.approx(np.array([[0, 0], [4, 0], [4, 3]]))


def shapes(path, xml):
    """Write an additional file with these shapes to the folder of the source's other files."""
    (path / "shapes.add.xml").write_text(f"<additional>{xml}</additional>")
    return {"additional": ["shapes.add.xml"]}


def test_shapes_are_converted_by_their_types(sumo, tmp_path):
    keys = shapes(
        tmp_path,
        """<poly id="1" type="barrier.guard_rail" shape="0,0 1,0"/>
        <poly id="2" type="wall" shape="0,0 4,0 4,3 0,0"><param key="height" value="1.2"/></poly>
        <poly id="3" type="sign gantry" shape="0,0 8,0 8,1 0,1">
            <param key="height" value="6.5"/><param key="base" value="5"/><param key="reflectivity" value="0.5"/></poly>
        <poly id="4" type="pole" shape="0,0 1,0 1,1"/>
        <poi id="5" type="natural.tree" x="10" y="20"><param key="diameter" value="0.6"/></poi>
        <poi id="6" type="building" x="0" y="0"/>
        <poi id="7" type="mast" x="0" y="0"><param key="height" value="9"/></poi>""",
    )
    obstacles = sumo(**keys).reset(0)
    beam, post, *wall, gantry, pole, tree, mast = range(len(obstacles))
    assert obstacles.height[[beam, post]] == pytest.approx([0.787, 0.475])
    assert obstacles.base[[beam, post]] == pytest.approx([0.475, 0.0])
    assert list(obstacles.height[wall]) == [1.2] * 3  # a line keeps its closing point
    sizes = np.column_stack([obstacles.base, obstacles.height, obstacles.reflectivity])
    assert list(sizes[gantry]) == [5.0, 6.5, 0.5]
    assert list(obstacles.height[[pole, tree, mast]]) == [8.0, 4.0, 9.0]
    assert list(np.diff(obstacles.offset)[[pole, tree, mast]]) == [3, 8, 8]
    trunk = obstacles.vertices_world[obstacles.offset[tree] : obstacles.offset[tree + 1]]
    assert trunk.mean(axis=0) == pytest.approx([10.0, 20.0])
    assert np.ptp(trunk, axis=0) == pytest.approx(0.6, abs=0.04)


# ---- standing vehicles


def test_parked_and_stopped_cars_are_stationary_actors(sumo, tmp_path):
    """In a parking area, at the kerb, in the lane: SUMO removes the first two from the lane, but not from the world."""
    route, _, _ = EASTBOUND.splitlines()
    stops = {
        "area": 'parkingArea="p"',
        "kerb": 'lane="west_in_1" startPos="40" endPos="60" parking="true"',
        "lane": 'lane="west_in_1" startPos="60" endPos="80"',
    }
    standing = "".join(
        f'<vehicle id="{name}" route="east" depart="0" departPos="stop" departLane="1">'
        f'<stop {where} duration="900"/></vehicle>'
        for name, where in stops.items()
    )
    keys = shapes(tmp_path, '<parkingArea id="p" lane="west_in_1" startPos="10" endPos="30" roadsideCapacity="2"/>')
    ego = '<vehicle id="ego" route="east" depart="5" departPos="50" departLane="2" departSpeed="0"/>'
    seen = frames(sumo(route + standing + ego, ego="vehicle:ego", **keys), 20)
    assert seen[-1].ego.velocity_world[0] > 1.0
    for frame in seen:
        rows = [list(frame.actors.name).index(name) for name in stops]
        assert (frame.actors.kind[rows] == Kind.CAR).all()
        assert (frame.actors.velocity_world[rows] == 0).all()
        assert (frame.actors.yaw_rate[rows] == 0).all()
        assert np.array_equal(frame.actors.pose_world[rows], seen[0].actors.pose_world[rows])
    at, along = lane_point("west_in_1", 60.0)
    to_the_left = (seen[0].actors.pose_world[rows, :2] - at) @ (-along[1], along[0])
    assert to_the_left[2] == pytest.approx(0.0, abs=0.1)
    assert (to_the_left[:2] < -1.5).all()


# ---- selection and end of the ego


@pytest.mark.parametrize(
    ("ego", "name"),
    [("first", "first"), ("vehicle:second", "second"), ("route:east", "first"), ("route:!late", "late")],
)
def test_the_ego_is_selected(sumo, ego, name):
    late = '<vehicle id="late" depart="2"><route edges="north_in south_out"/></vehicle>'
    routes = EASTBOUND.replace('<vehicle id="second"', late + '<vehicle id="second"')
    source = sumo(routes, ego=ego)
    source.reset(1)
    assert source.step().time == 0.0
    assert source._ego == name


def test_vehicles_not_sorted_by_departure_are_not_lost(sumo):
    """By default SUMO drops them, with a warning that is suppressed."""
    route, first, second = EASTBOUND.splitlines()
    source = sumo("\n".join([route, second, first]), ego="vehicle:first", range_m=200.0)
    assert list(frames(source, 60)[-1].actors.name) == ["second"]


def test_the_run_ends_when_the_ego_leaves(sumo):
    source = sumo()
    source.reset(1)
    with pytest.raises(TrafficEndedError, match=r'ego "first" left the net at \d+\.\d\d s'):
        play(source, 2000)
    with pytest.raises(TrafficEndedError):
        source.step()


# ---- discontinuous motion


@pytest.mark.parametrize(
    ("name", "options", "sign"),
    [
        # without a lateral resolution, lane changes take one step
        ("highway/sumo-cut-in", {}, "changes lane"),
        # vehicles that stand for a second are teleported
        ("urban/sumo-crossing", {"lateral-resolution": "0.8", "time-to-teleport": "1"}, "#2"),
    ],
    ids=["lane changes in one step", "teleports"],
)
def test_jumps_in_sumo_do_not_reach_the_frames(name, options, sign):
    scenario = Scenario.load(CATALOG / f"{name}.toml")
    config = replace(scenario.traffic, options=options)
    signs, last = set(), {}
    with closing(SumoSource(config, scenario.folder, 80.0)) as source:
        source.reset(1)
        for _ in range(130):
            actors = source.step().actors
            signs |= {label[label.find("#") :] for label in actors.name if "#" in label}
            signs |= {"changes lane"} if actors.changes_lane.any() else set()
            velocity = dict(zip(actors.id.tolist(), actors.velocity_world, strict=True))
            place = dict(zip(actors.id.tolist(), actors.pose_world[:, :2], strict=True))
            for number in place.keys() & last.keys():
                moved = (place[number] - last[number]) / source.dt
                assert np.hypot(*(moved - velocity[number])) < 0.6
            last = place
    assert sign in signs, "SUMO made no jump, so the test is void"


# ---- bad input: an error of one line, and no output on the terminal


def error_message(source, error=TrafficInputError):
    with pytest.raises(error) as caught:
        source.reset(1)
    assert "\n" not in str(caught.value)
    return str(caught.value)


def test_a_missing_file_is_named(sumo):
    assert "gone.net.xml: no such file" in error_message(sumo(net="gone.net.xml"))
    assert "gone.rou.xml: no such file" in error_message(sumo(routes=["gone.rou.xml"]))
    assert "gone.sumocfg: no such file" in error_message(sumo(config="gone.sumocfg", net="", routes=[]))


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("hello", "is not valid XML"),
        ("", "is not valid XML"),
        ("<net><edge", "no <net version"),  # libsumo would crash the process
        ("<routes/>", "no <net version"),
        ('<net version="1.20"><edge', "unexpected end of input"),
        ('<net version="1.20"><edge id="a" from="b" to="c"/></net>', "Unknown from-node 'b'"),
    ],
)
def test_an_invalid_net_is_rejected(sumo, tmp_path, capfd, text, why):
    (tmp_path / "bad.net.xml").write_text(text)
    assert why in error_message(sumo(net="bad.net.xml"))
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize(
    ("routes", "keys", "why"),
    [
        ('<route id="r" edges="west_in nowhere"/>', {}, "edge 'nowhere' within the route 'r' is not known"),
        ("<vehicle", {}, "traffic.rou.xml"),
        ('<vehicle id="v" depart="0" departLane="9"><route edges="west_in"/></vehicle>', {}, "departLane"),
        (EASTBOUND, {"options": {"lateral-resolutio": "1"}}, "No option with the name 'lateral-resolutio'"),
        (EASTBOUND, {"options": {"lateral-resolution": "wide"}}, "'wide' is not a valid float"),
    ],
)
def test_bad_routes_and_options_are_rejected(sumo, capfd, routes, keys, why):
    assert why in error_message(sumo(routes, **keys))
    assert capfd.readouterr() == ("", "")


def test_an_ego_that_does_not_enter_is_an_error(sumo):
    message = error_message(sumo(ego="vehicle:eggo"))
    assert 'ego = "vehicle:eggo" did not enter' in message
    assert "first, second" in message
    assert "did not enter in 2 s" in error_message(sumo(ego="vehicle:second", max_wait_s=2.0))
    assert "these did: east" in error_message(sumo(ego="route:west"))


@pytest.mark.parametrize(
    ("parameter", "remedy"),
    [
        (("height", "tall"), 'height = "tall"'),
        (("height", "-2"), "height must be"),
        (("base", "20"), "above its base"),
        (("reflectivity", "3"), "between 0 and 1"),
    ],
)
def test_invalid_parameters_of_shapes_are_rejected(sumo, tmp_path, parameter, remedy):
    key, value = parameter
    building = f'<poly id="b" type="building" shape="0,0 1,0 1,1"><param key="{key}" value="{value}"/></poly>'
    message = error_message(sumo(**shapes(tmp_path, building)))
    assert message.startswith('polygon "b": ')
    assert remedy in message


@pytest.mark.parametrize(
    "keys",
    [
        {},
        {"net": "a.net.xml"},
        {"config": "a.sumocfg", "net": "a.net.xml", "routes": ["b"]},
        {"config": "a.sumocfg", "additional": ["b"]},
        {"config": "a.sumocfg", "ego": "second"},
        {"config": "a.sumocfg", "ego": "vehicle:"},
        {"config": "a.sumocfg", "dt_s": 0.0},
        {"config": "a.sumocfg", "dt_s": 1 / 30},  # SUMO would step 33 ms
        {"config": "a.sumocfg", "options": {"seed": "3"}},
        {"config": "a.sumocfg", "options": {"srand": "3"}},  # a synonym of seed
    ],
)
def test_contradictory_settings_are_rejected(keys):
    with pytest.raises(ValueError, match=r"^[^\n]+$"):
        SumoTraffic(**keys)


def test_an_error_of_sumo_during_the_run_is_a_simulator_failure(sumo):
    # with this option SUMO reads routes incrementally, 200 s ahead
    traffic = """<route id="west" edges="west_in"/>
    <vehicle id="ego" route="west" depart="0"><stop lane="west_in_1" endPos="50" duration="500"/></vehicle>
    <vehicle id="next" route="west" depart="210"/>
    <vehicle id="last" depart="230"><route edges="west_in nowhere"/></vehicle>"""
    source = sumo(traffic, dt_s=0.5, options={"route-steps": "200"})
    source.reset(1)
    with pytest.raises(SimulatorFailedError, match="edge 'nowhere'"):
        play(source, 500)


# ---- one process, one simulation


def test_a_second_simulation_is_rejected_until_the_first_is_closed(sumo):
    one, two = sumo(), sumo()
    one.reset(1)
    assert "one simulation per process" in error_message(two, SimulatorFailedError)
    assert one.step().index == 0, "the first one is unaffected"
    one.close()
    two.reset(1)
    one.close()
    assert two.step().index == 0, "closing twice must not end another run"


def test_after_bad_input_the_next_run_starts(sumo):
    error_message(sumo(ego="vehicle:eggo"))
    assert frames(sumo(), 2)[1].index == 1


def test_step_before_reset_raises(sumo):
    with pytest.raises(SimulatorFailedError, match="call reset before step"):
        sumo().step()


# ---- configuration files


def test_a_sumocfg_with_a_compressed_net_runs_without_output(sumo, tmp_path, capfd):
    (tmp_path / "sub").mkdir()
    with gzip.open(tmp_path / "sub" / "crossing.net.xml.gz", "wb") as packed:
        packed.write(NET.read_bytes())
    (tmp_path / "sub" / "run.sumocfg").write_text("""<configuration>
        <input><net-file value="crossing.net.xml.gz"/><route-files value="../traffic.rou.xml"/></input>
        <report><verbose value="true"/></report></configuration>""")
    assert len(frames(sumo(config="sub/run.sumocfg", net="", routes=[]), 3)) == 3
    assert capfd.readouterr() == ("", "")


def test_a_sumocfg_without_a_net_or_that_is_not_xml_is_rejected(sumo, tmp_path):
    (tmp_path / "a.sumocfg").write_text("<configuration/>")
    (tmp_path / "b.sumocfg").write_text("net = 3")
    assert "no net-file" in error_message(sumo(config="a.sumocfg", net="", routes=[]))
    assert "not a SUMO configuration" in error_message(sumo(config="b.sumocfg", net="", routes=[]))


# ---- the scenarios


def run(name):
    scenario = Scenario.load(CATALOG / f"{name}.toml")
    with closing(SumoSource(scenario.traffic, scenario.folder, 60.0)) as source:
        obstacles = source.reset(scenario.seed)
        return obstacles, [source.step() for _ in range(round(scenario.duration_s / source.dt))]


def in_ego_frame(frame):
    """Return x, y of actors in the ego frame."""
    cos, sin = np.cos(frame.ego.pose_world[2]), np.sin(frame.ego.pose_world[2])
    return (frame.actors.pose_world[:, :2] - frame.ego.pose_world[:2]) @ np.array([[cos, -sin], [sin, cos]])


def test_the_crossing_has_dense_and_crossing_traffic():
    obstacles, seen = run("urban/sumo-crossing")
    near = [int((np.hypot(*in_ego_frame(frame).T) <= 50.0).sum()) for frame in seen]
    assert np.mean(np.array(near) >= 10) > 0.75
    south, north = seen[0].ego.pose_world[1], seen[-1].ego.pose_world[1]
    assert south < -100.0
    assert north > 40.0
    assert min(np.hypot(*frame.ego.velocity_world) for frame in seen) < 0.1, "the ego should wait at the traffic light"
    kinds = {Kind(kind) for frame in seen for kind in frame.actors.kind}
    assert kinds >= {Kind.CAR, Kind.SUV, Kind.VAN, Kind.TRUCK, Kind.BUS, Kind.MOTORCYCLE}
    corners = obstacles.vertices_world
    for east, north in [(1, 1), (1, -1), (-1, 1), (-1, -1)]:
        at_corner = (corners * (east, north) > 0).all(axis=1) & (np.hypot(*corners.T) < 40.0)
        assert at_corner.any(), "every corner should have a building"
    assert obstacles.height.min() > 2.0


@pytest.mark.slow
def test_vehicles_cut_in_on_the_motorway():
    _, seen = run("highway/sumo-cut-in")
    beside, cut_in = set(), set()
    for frame in seen:
        for number, (x, y) in zip(frame.actors.id, in_ego_frame(frame), strict=True):
            if 5.0 < x < 50.0 and abs(y) > 2.5:
                beside.add(number)
            if 5.0 < x < 50.0 and abs(y) < 1.2 and number in beside:
                cut_in.add(number)
    assert len(cut_in) >= 3
