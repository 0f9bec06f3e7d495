"""Random sizes in place of default sizes, with the real simulators."""

from contextlib import closing
from pathlib import Path

import numpy as np
import pytest
from support.paths import CATALOG
from support.traffic import frames

from luxloop.sim.actor_draws import RANGES, redrawn_size
from luxloop.sim.highway.highway_config import HighwayTraffic
from luxloop.sim.highway.highway_source import HighwaySource
from luxloop.sim.roster import Roster
from luxloop.sim.sumo.sumo_config import SumoTraffic
from luxloop.sim.sumo.sumo_source import SumoSource
from luxloop.sim.world import Kind

NET = CATALOG / "urban" / "sumo-crossing" / "crossing.net.xml"
CLASSES = ("passenger", "delivery", "truck", "trailer", "bus", "coach", "motorcycle", "moped", "bicycle", "scooter")
ROUTE = '<route id="east" edges="west_in east_out"/>'


@pytest.fixture
def first_frame(tmp_path):
    """Return a function that plays the first frame of a route file on the crossing's net."""

    def play(traffic, ego, **keys):
        (tmp_path / "traffic.rou.xml").write_text(f"<routes>{ROUTE}{traffic}</routes>")
        config = SumoTraffic(net=str(NET), routes=["traffic.rou.xml"], ego=f"vehicle:{ego}", **keys)
        with closing(SumoSource(config, tmp_path, 150.0)) as source:
            return frames(source, 1)[0]

    return play


def parked(name, place, vehicle_type):
    return (
        f'<vehicle id="{name}" route="east" type="{vehicle_type}" depart="0" departPos="{place}" departLane="1">'
        f'<stop lane="west_in_1" endPos="{place + 0.5}" duration="50"/></vehicle>'
    )


def cars(count):
    return "".join(parked(f"car{n}", 90 - 9 * n, "DEFAULT_VEHTYPE") for n in range(count))


def by_name(frame):
    return {str(name): row for row, name in enumerate(frame.actors.name)}


@pytest.mark.parametrize("vehicle_class", CLASSES)
def test_the_table_has_the_default_size_of_every_class_of_sumo(first_frame, vehicle_class):
    """Fails if SUMO's default sizes or shape names differ from the table: sizes would not be redrawn."""
    types = f'<vType id="sort" vClass="{vehicle_class}"/>'
    traffic = types + parked("ego", 90, "DEFAULT_VEHTYPE") + parked("other", 60, "sort")
    default = first_frame(traffic, "ego", redraw_default_sizes=False)
    row = by_name(default)["other"]
    key = (Kind(default.actors.kind[row]), tuple(default.actors.size[row].tolist()))
    assert key in RANGES
    redrawn = first_frame(traffic, "ego")
    low, high = RANGES[key]
    size = redrawn.actors.size[by_name(redrawn)["other"]]
    assert np.all(size >= low)
    assert np.all(size <= high)
    assert np.all(size != key[1])


def test_random_sizes_are_not_longer_or_wider_than_the_default():
    """Fails if bodies could overlap although the simulator has no collision."""
    for (_, default), (low, high) in RANGES.items():
        assert np.all(np.array(high[:2]) <= default[:2])
        assert np.all(np.array(low) <= high)


def test_front_bumpers_are_unchanged_by_random_sizes(first_frame):
    """Fails if the centre is computed from SUMO's length."""
    default = first_frame(cars(6), "car3", redraw_default_sizes=False)
    redrawn = first_frame(cars(6), "car3")
    assert list(default.actors.name) == list(redrawn.actors.name)
    assert len(set(redrawn.actors.size[:, 0])) == 5
    for frame, other in ((default, redrawn), (redrawn, default)):
        np.testing.assert_allclose(front_bumpers(frame), front_bumpers(other), atol=1e-9)
    assert redrawn.ego.size == pytest.approx([5.0, 1.8, 1.5]), "the rig fits the ego's original size"
    np.testing.assert_array_equal(default.actors.reflectivity, redrawn.actors.reflectivity)


def front_bumpers(frame):
    pose, length = frame.actors.pose_world, frame.actors.size[:, :1]
    return pose[:, :2] + 0.5 * length * np.column_stack([np.cos(pose[:, 2]), np.sin(pose[:, 2])])


def test_types_with_an_explicit_size_keep_it(first_frame):
    own = '<vType id="own" length="4.99"/><vType id="tall" height="1.51"/>'
    traffic = own + parked("ego", 90, "DEFAULT_VEHTYPE") + parked("a", 70, "own") + parked("b", 50, "tall")
    frame = first_frame(traffic, "ego")
    rows = by_name(frame)
    assert frame.actors.size[rows["a"]] == pytest.approx([4.99, 1.8, 1.5], abs=0)
    assert frame.actors.size[rows["b"]] == pytest.approx([5.0, 1.8, 1.51], abs=0)


def test_a_size_depends_only_on_seed_and_name():
    size = (5.0, 1.8, 1.5)
    drawn = redrawn_size(Kind.CAR, size, seed=3, name="taxi")
    assert redrawn_size(Kind.CAR, size, seed=3, name="taxi") == drawn
    assert redrawn_size(Kind.CAR, size, seed=3, name="hearse") != drawn
    assert redrawn_size(Kind.CAR, size, seed=4, name="taxi") != drawn
    crowded, sparse = (Roster(3, redraw_default_sizes=True) for _ in range(2))
    for number in range(7):
        crowded.add(number, Kind.BUS, (12.0, 2.5, 3.4))
    sparse.add("ego", Kind.CAR, size)
    assert crowded.add("x", Kind.CAR, size, "taxi").size == sparse.add("x", Kind.CAR, size, "taxi").size == drawn


def test_cars_of_highway_env_keep_their_centres():
    def first(**keys):
        source = HighwaySource(HighwayTraffic(env="highway-v0", config={"vehicles_count": 12}, **keys), Path(), 200.0)
        (frame,) = frames(source, 1, seed=4)
        source.close()
        return frame

    redrawn, default = first(), first(redraw_default_sizes=False)
    assert np.all(default.actors.size == (5.0, 2.0, 1.5))
    low, high = RANGES[Kind.CAR, (5.0, 2.0, 1.5)]
    assert np.all((redrawn.actors.size >= low) & (redrawn.actors.size <= high))
    assert len(set(redrawn.actors.size[:, 1])) == len(redrawn.actors)
    np.testing.assert_array_equal(redrawn.actors.pose_world, default.actors.pose_world)
    assert redrawn.ego.size == pytest.approx([5.0, 2.0, 1.5])
