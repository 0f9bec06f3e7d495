"""Parked cars: the same poses as of vehicles parked by SUMO, on a random share of the places."""

import math

import libsumo
import pytest
from support.paths import NETS

from luxloop.sim.sumo.input_checks import sumo_command
from luxloop.sim.sumo.parking import parked_cars
from luxloop.sim.world import Kind

WINDING, LEFT_HAND = NETS / "winding" / "winding.net.xml", NETS / "left-hand" / "left-hand.net.xml"


@pytest.fixture
def park(tmp_path):
    """Return a function that runs SUMO with vehicles that stop on the parking area `p`; end SUMO afterwards."""

    def run(area, net=WINDING, edge="", count=0):
        vehicles = "".join(
            f'<vehicle id="{k}" depart="{2 * k}"><route edges="{edge}"/>'
            '<stop parkingArea="p" duration="9999"/></vehicle>'
            for k in range(count)
        )
        (tmp_path / "a.add.xml").write_text(f"<additional>{area}</additional>")
        (tmp_path / "r.rou.xml").write_text(f"<routes>{vehicles}</routes>")
        files = {"net-file": [str(net)], "route-files": ["r.rou.xml"], "additional-files": ["a.add.xml"]}
        command = sumo_command(tmp_path, files, 1.0, 1, {})
        libsumo.start(command)
        for _ in range(count * 20 + 40):
            libsumo.simulationStep()
        (tmp_path / "r.rou.xml").write_text("<routes/>")  # otherwise the area would stay empty for these vehicles
        return command

    yield run
    if libsumo.isLoaded():
        libsumo.close()


def area(lane, inside="", **keys):
    keys = {"startPos": "20", "endPos": "60", "roadsideCapacity": "4"} | keys
    return f'<parkingArea id="p" lane="{lane}" {" ".join(f"{k}={v!r}" for k, v in keys.items())}>{inside}</parkingArea>'


LOTS = [
    (WINDING, "start_0", {}),
    (WINDING, "start_0", {"angle": "45"}),
    (WINDING, "start_0", {"angle": "90", "length": "5", "width": "3"}),
    (WINDING, "start_0", {"angle": "120", "length": "5", "width": "2.6"}),
    (WINDING, "start_0", {"angle": "225", "length": "6"}),
    (WINDING, "start_0", {"angle": "300", "length": "6"}),
    (WINDING, "start_0", {"angle": "-30", "length": "6"}),
    (WINDING, "start_0", {"startPos": "-80", "endPos": "-20", "length": "6"}),
    (WINDING, "r80_0", {}),
    (WINDING, "r80_0", {"angle": "30", "length": "5.5", "width": "2.4"}),
    (WINDING, "r80_back_0", {"angle": "90", "length": "5", "width": "2.4"}),
    (WINDING, "r40_0", {"roadsideCapacity": "3"}),
    (LEFT_HAND, "bottom0A0_0", {}),
    (LEFT_HAND, "bottom0A0_0", {"angle": "-45", "length": "5", "width": "2.2"}),
]


CORNER = """<net version="1.20">
<location netOffset="0,0" convBoundary="0,-60,110,60" origBoundary="0,-60,110,60" projParameter="!"/>
<edge id="bend" from="a" to="b" priority="1">
<lane id="bend_0" index="0" speed="9.0" length="100.0" shape="0,0 50,0 {end}"/>
</edge>
<junction id="a" type="dead_end" x="0" y="0" incLanes="" intLanes="" shape="0,0 0,-1.6"/>
<junction id="b" type="dead_end" x="{x}" y="{y}" incLanes="bend_0" intLanes="" shape="{end} {end}"/>
</net>"""


def assert_parked_alike(cars, names):
    assert len(cars) == len(names)
    for car, name in zip(cars, names, strict=True):
        assert libsumo.vehicle.isStoppedParking(name)
        x, y, yaw = car.pose
        half = car.size[0] / 2
        front = (x + half * math.cos(yaw), y + half * math.sin(yaw))
        assert front == pytest.approx(libsumo.vehicle.getPosition(name), abs=0.1)
        turned = math.remainder(math.degrees(yaw) - 90.0 + libsumo.vehicle.getAngle(name), 360.0)
        assert turned == pytest.approx(0.0, abs=1.0)


@pytest.mark.parametrize(("net", "lane", "keys"), LOTS)
def test_roadside_places_match_sumo(park, net, lane, keys):
    command = park(area(lane, **keys), net, lane.rpartition("_")[0], int(keys.get("roadsideCapacity", 4)))
    cars = parked_cars(command, libsumo.lane, 1.0, 1)
    assert_parked_alike(cars, sorted(libsumo.vehicle.getIDList()))


@pytest.mark.parametrize("keys", [{}, {"angle": "60", "length": "5", "width": "2.4"}], ids=["along", "oblique"])
@pytest.mark.parametrize("corner_deg", [-90, -45, 45, 90])
def test_places_around_a_sharp_corner_match_sumo(park, tmp_path, corner_deg, keys):
    """A lane of two straights: the row of places has a mitre on either side of its corner."""
    turn = math.radians(corner_deg)
    end = f"{50 + 50 * math.cos(turn):.3f},{50 * math.sin(turn):.3f}"
    net = tmp_path / "corner.net.xml"
    net.write_text(CORNER.format(end=end, x=end.partition(",")[0], y=end.partition(",")[2]))
    command = park(area("bend_0", startPos="25", endPos="75", roadsideCapacity="5", **keys), net, "bend", 5)
    assert_parked_alike(parked_cars(command, libsumo.lane, 1.0, 1), sorted(libsumo.vehicle.getIDList()))


def test_single_places_match_sumo(park):
    spaces = (
        '<space x="60" y="-8"/><space x="65" y="-8" angle="30"/><space x="70" y="-9" angle="120" length="4" width="2"/>'
    )
    command = park(area("start_0", spaces, roadsideCapacity="1", angle="20", length="6"), WINDING, "start", 4)
    cars = parked_cars(command, libsumo.lane, 1.0, 1)
    assert_parked_alike(cars, sorted(libsumo.vehicle.getIDList()))
    assert [car.name for car in cars] == ["p.0", "p.1", "p.2", "p.3"]
    assert [car.size for car in cars] == [(5.0, 1.8, 1.5)] * 3 + [(4.0, 1.8, 1.5)]
    assert {car.kind for car in cars} == {Kind.CAR}


def test_occupied_places_are_drawn_independently_by_the_seed(park, tmp_path):
    command = park(area("start_0", roadsideCapacity="20", length="5", angle="60"))
    taken = {(fill, seed): parked_cars(command, libsumo.lane, fill, seed) for fill in (0.3, 0.6) for seed in range(30)}
    assert sum(len(taken[0.3, seed]) for seed in range(30)) / 600 == pytest.approx(0.3, abs=0.06)  # 3 sigma
    assert taken[0.3, 1] != taken[0.3, 2]
    assert all(set(taken[0.3, seed]) <= set(taken[0.6, seed]) for seed in range(30)), (
        "a higher fill must not empty a place"
    )
    listed = tmp_path / "a.add.xml"
    listed.write_text(listed.read_text().replace('id="p"', 'id="q"'))
    (other,) = {car.name[0] for car in parked_cars(command, libsumo.lane, 0.3, 1)}
    assert other == "q"
    assert parked_cars(command, libsumo.lane, 0.0, 1) == []


def test_areas_on_the_road_areas_in_use_and_small_places_stay_empty(park, tmp_path):
    lots = (
        '<parkingArea id="on" lane="start_0" startPos="10" endPos="30" roadsideCapacity="2" onRoad="true"/>'
        '<parkingArea id="used" lane="start_0" startPos="40" endPos="60" roadsideCapacity="2"/>'
        '<parkingArea id="bikes" lane="start_0" startPos="70" endPos="90" roadsideCapacity="20"/>'
        '<parkingArea id="rerouted" lane="start_0" startPos="70" endPos="90" roadsideCapacity="2"/>'
        '<parkingArea id="free" lane="start_0" startPos="100" endPos="120" roadsideCapacity="2"/>'
        '<rerouter id="r" edges="start"><interval end="9"><parkingAreaReroute id="rerouted"/></interval></rerouter>'
    )
    command = park(lots)
    (tmp_path / "r.rou.xml").write_text(
        '<routes><vehicle id="v" depart="0"><stop parkingArea="used" duration="9"/></vehicle></routes>'
    )
    assert [car.name for car in parked_cars(command, libsumo.lane, 1.0, 1)] == ["free.0", "free.1"]
