"""Properties of SUMO traffic on the various nets of tests/nets."""

from contextlib import closing
from dataclasses import fields
from itertools import pairwise

import numpy as np
import pytest
from support.motion_limits import excesses, worst_motion
from support.nets import TRAFFIC, source_on

from luxloop.sim.world import Kind

FRAMES = 200
RANGE_M = 300.0
FASTEST = 45.0
"""[m/s] Maximum speed on these nets."""
TOO_SHARP = {"spider"}
"""SUMO takes corners of junctions at speeds at which feasible motion runs wide and late."""


class Run:
    """First frames on a net."""

    def __init__(self, name):
        self.name = name
        with closing(source_on(name, RANGE_M, parking_fill=0.7)) as source:
            self.obstacles = source.reset(1)
            self.origin, self.dt = source.origin, source.dt
            self.frames = [source.step() for _ in range(FRAMES)]
        self.kinds = {Kind(kind) for frame in self.frames for kind in frame.actors.kind}


RUNS = {}


@pytest.fixture(params=TRAFFIC)
def run(request):
    return run_on(request.param)


def run_on(name):
    if name not in RUNS:
        RUNS[name] = Run(name)
    return RUNS[name]


def test_ids_are_sorted_and_never_reused(run):
    known = {}
    for frame in run.frames:
        actors = frame.actors
        assert (np.diff(actors.id) > 0).all()
        for row, number in enumerate(actors.id.tolist()):
            properties = (str(actors.name[row]), int(actors.kind[row]), *actors.size[row], actors.reflectivity[row])
            assert known.setdefault(number, properties) == properties
    assert len(known) > 10


def test_all_values_are_finite(run):
    assert np.isfinite(run.obstacles.vertices_world).all()
    for frame in run.frames:
        for record in (frame.ego, frame.actors):
            for field in fields(record):
                values = np.asarray(getattr(record, field.name))
                assert values.dtype.kind in "US" or np.isfinite(values).all(), field.name


def test_no_actor_jumps_across_the_map(run):
    for before, after in pairwise(run.frames):
        _, old, new = np.intersect1d(before.actors.id, after.actors.id, return_indices=True)
        step = after.actors.pose_world[new, :2] - before.actors.pose_world[old, :2]
        assert (np.hypot(*step.T) <= FASTEST * run.dt).all()
        assert (np.hypot(*(after.ego.pose_world - before.ego.pose_world)[:2]) <= FASTEST * run.dt).all()


def test_motions_are_feasible(run):
    lines = excesses(worst_motion(run.frames, run.dt))
    if run.name in TOO_SHARP:
        lines = [line for line in lines if not line.startswith("deviation")]
    assert lines == []


def test_poses_resolve_millimetres_in_single_precision(run):
    for frame in run.frames:
        place = np.vstack([frame.ego.pose_world[:2], frame.actors.pose_world[:, :2]])
        assert np.abs(place - place.astype(np.float32)).max() < 1e-3


# ---- properties of single nets


def test_large_coordinates_are_relative_to_an_origin_at_multiples_of_10_km():
    run = run_on("far-off")
    assert list(run.origin) == [500_000.0, 5_400_000.0]
    assert run.obstacles.vertices_world == pytest.approx(np.array([[130, 130], [150, 130], [150, 150], [130, 150]]))
    assert list(run_on("grid").origin) == [0.0, 0.0]


def test_all_kinds_of_road_users_occur():
    assert Kind.PEDESTRIAN in run_on("far-off").kinds
    assert {Kind.BICYCLE, Kind.MOTORCYCLE, Kind.CAR, Kind.SUV, Kind.VAN, Kind.TRUCK, Kind.BUS} <= run_on("grid").kinds
    winding = run_on("winding").frames
    trams = {size for frame in winding for size in frame.actors.size[np.char.startswith(frame.actors.name, "trams"), 0]}
    assert trams == {22.0}


def test_parked_cars_occupy_a_share_of_the_places():
    frames = run_on("far-off").frames
    parked = {str(name) for frame in frames for name in frame.actors.name if str(name).startswith("lay-by")}
    assert 2 <= len(parked) < 8
    for frame in frames:
        rows = np.isin(frame.actors.name, list(parked))
        assert not frame.actors.velocity_world[rows].any()
        assert frame.actors.pose_world[rows, 1] == pytest.approx(112.5)


def test_imported_buildings_are_obstacles_and_landuse_is_not():
    run = run_on("spreewaldring")
    assert len(run.obstacles) == 3  # of ten polygons, seven are landuse
    assert list(run.obstacles.height) == [10.0] * 3
    assert list(np.diff(run.obstacles.offset)) == [4, 4, 5]  # without the closing corner


def test_traffic_on_the_left_hand_net_keeps_to_the_left():
    # the arm from the south to the left-hand junction is at x = 120: northbound traffic is on its west side
    seen = [
        (x, yaw)
        for frame in run_on("left-hand").frames
        for x, y, yaw in frame.actors.pose_world[np.hypot(*frame.actors.velocity_world.T) > 3.0]
        if abs(x - 120.0) < 8.0 and 10.0 < y < 100.0
    ]
    assert len(seen) > 50
    assert all((x < 120.0) == (yaw > 0) for x, yaw in seen)


def test_instant_lane_changes_are_marked():
    for name in ("roundabout", "motorway"):
        assert any(frame.actors.changes_lane.any() for frame in run_on(name).frames)
    assert not any(frame.actors.changes_lane.any() for frame in run_on("grid").frames), (
        "lane changes on this net are gradual"
    )
