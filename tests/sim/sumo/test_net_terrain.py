"""Terrain of SUMO nets, read from their files, and traffic on it."""

import gzip
import math
from contextlib import closing

import numpy as np
import pytest
from support.nets import source_on
from support.paths import CATALOG, NETS

from luxloop.sim.source import TrafficInputError
from luxloop.sim.sumo.net_terrain import BRIDGES, lane_sections, net_terrain
from luxloop.sim.sumo.sumo_config import SumoTraffic
from luxloop.sim.sumo.sumo_source import SumoSource

RAMP = CATALOG / "urban/ramp"
FOOT_M, CREST_M, TOP_M = 200.0, 350.0, 9.0
"""Of the ramp, from its README: 9 m over 150 m are 6 %."""


def net(lanes):
    edges = "".join(
        f'<edge id="e{n}"><lane id="e{n}_0" index="0" speed="14" length="100" shape="{shape}"/></edge>'
        for n, shape in enumerate(lanes)
    )
    return f'<net version="1.20">{edges}<junction id="j" x="0" y="0" z="6.00"/></net>'


def test_flat_nets_have_no_terrain_and_frames_at_height_0():
    with closing(source_on("grid", suspension=False)) as source:
        assert source.reset(1).terrain is None
        frame = source.step()
    assert frame.ego.ground_z == 0.0
    assert not frame.actors.ground_z.any()
    assert not frame.ego.attitude.any()
    assert not frame.actors.attitude.any()


def test_net_compressed_by_gzip_gives_the_same_terrain(tmp_path):
    packed = tmp_path / "ramp.net.xml.gz"
    packed.write_bytes(gzip.compress((RAMP / "ramp.net.xml").read_bytes()))
    plain, unpacked = net_terrain(RAMP / "ramp.net.xml"), net_terrain(packed)
    assert (plain.terrain.height == unpacked.terrain.height).all()


def test_bridges_are_detected_and_walking_areas_ignored(tmp_path):
    file = tmp_path / "bridge.net.xml"
    file.write_text(net(["0,0 100,0", "50,-50,6 50,50,6"]))
    found = net_terrain(file)
    assert found.bridges
    assert found.warnings == (BRIDGES,)
    file.write_text(net(["0,0 100,0", "150,-50,6 150,50,6"]))
    assert not net_terrain(file).bridges
    file.write_text(net(["0,0,6 100,0,6"]).replace('<edge id="e0"', '<edge id="e0" function="walkingarea"'))
    assert lane_sections(file) is None


def test_a_lane_reaches_half_its_width_from_its_line(tmp_path):
    file = tmp_path / "wide.net.xml"
    file.write_text(net(["0,0,1 50,0,1 100,0,2", "0,9,1 100,9,1"]).replace('id="e0_0"', 'id="e0_0" width="5.0"'))
    assert lane_sections(file).half_width.tolist() == [2.5, 2.5, 1.6]


def test_damaged_lane_is_refused_in_one_line(tmp_path):
    file = tmp_path / "odd.net.xml"
    file.write_text(net(["0,0,1 100,x,1"]))
    with pytest.raises(TrafficInputError, match=r"odd\.net\.xml: its lanes cannot be read") as refusal:
        lane_sections(file)
    assert "\n" not in str(refusal.value)


@pytest.fixture(scope="module")
def drive():
    """Return terrain and frames of the catalog's ramp."""
    traffic = SumoTraffic(
        net="ramp.net.xml",
        routes=["ramp.rou.xml"],
        ego="vehicle:ego",
        suspension=False,
        options={"lateral-resolution": "0.8"},
    )
    with closing(SumoSource(traffic, RAMP, 100.0)) as source:
        terrain = source.reset(1).terrain
        return terrain, [source.step() for _ in range(260)]


def test_vehicles_on_the_ramp_have_its_height_and_slope(drive):
    """By hand: z = 0.06 (x - 200) between foot and crest; atan(0.06) = 3.434 degrees, front up on the way up."""
    _, frames = drive
    seen_up = seen_down = 0
    for frame in frames:
        actors = frame.actors
        x, yaw = actors.pose_world[:, 0], actors.pose_world[:, 2]
        on_ramp = (x > FOOT_M + 8.0) & (x < CREST_M - 8.0)
        assert actors.ground_z[on_ramp] == pytest.approx(0.06 * (x[on_ramp] - FOOT_M), abs=0.02)
        uphill = np.abs(yaw) < 0.5 * math.pi
        for rows, sign in ((on_ramp & uphill, -1.0), (on_ramp & ~uphill, 1.0)):
            pitch_deg = np.degrees(actors.attitude[rows, 0])
            assert pitch_deg == pytest.approx(np.full(rows.sum(), sign * 3.434), abs=0.15)
        seen_up, seen_down = seen_up + (on_ramp & uphill).sum(), seen_down + (on_ramp & ~uphill).sum()
        flat = (x < FOOT_M - 8.0) | (x > CREST_M + 8.0)
        assert actors.ground_z[flat] == pytest.approx(np.where(x[flat] < FOOT_M, 0.0, TOP_M), abs=0.01)
    assert min(seen_up, seen_down) > 100


def test_ego_climbs_the_ramp_from_foot_to_crest(drive):
    _, frames = drive
    height = np.array([frame.ego.ground_z for frame in frames])
    assert height[0] == 0.0
    assert height.max() > 7.0
    assert np.diff(height).min() > -1e-9


def test_speed_in_plan_is_less_than_along_the_slope(drive):
    """SUMO's speed is along the lane, whose length is that in space: 0.18 % more than in plan, 1 / cos(3.434 deg)."""
    _, frames = drive
    step = np.array([frame.ego.pose_world[:2] for frame in frames])
    travelled = np.hypot(*np.diff(step, axis=0).T) / 0.08
    speed = np.array([np.hypot(*frame.ego.velocity_world) for frame in frames])
    assert travelled == pytest.approx(0.5 * (speed[1:] + speed[:-1]), abs=0.02), "velocities are in plan"


def test_a_car_on_a_bridge_is_above_the_ego_on_the_road_below():
    """The bridge of the net is 6 m above the road. Both cars are near the crossing at the same time."""
    traffic = SumoTraffic(net="overpass.net.xml", routes=["overpass.rou.xml"], ego="vehicle:ego")
    with closing(SumoSource(traffic, NETS / "overpass", 150.0)) as source:
        source.reset(1)
        assert source.warnings == (BRIDGES,)
        frames = [source.step() for _ in range(60)]
    apart = np.array([frame.actors.pose_world[0, :2] - frame.ego.pose_world[:2] for frame in frames])
    assert np.hypot(*apart.T).min() < 5.0
    assert [frame.ego.ground_z for frame in frames] == pytest.approx([0.0] * len(frames), abs=0.01)
    height = np.array([frame.actors.ground_z[0] for frame in frames])
    assert height == pytest.approx(np.full(len(frames), 6.0), abs=0.1)
