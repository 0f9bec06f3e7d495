"""Another actor changes neither bodies nor paint, sizes, starts and noise of the others."""

from contextlib import closing
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from support.paths import CATALOG

from luxloop.sensor_model.lidar import Lidar
from luxloop.sensor_model.noise.noise_config import NoiseConfig, Outliers, Rain, Spray
from luxloop.sensor_model.rig.rig import load_rig
from luxloop.sensor_model.sensor_config import SensorConfig
from luxloop.sim.scripted.motions import Straight
from luxloop.sim.scripted.script import ScriptedActor, ScriptedEgo
from luxloop.sim.scripted.scripted_source import ScriptedSource, ScriptedTraffic
from luxloop.sim.sumo.sumo_config import SumoTraffic
from luxloop.sim.sumo.sumo_source import SumoSource

CROSSING = CATALOG / "urban" / "sumo-crossing" / "crossing.net.xml"
RIG = load_rig("srx_six_lux", Path())
NOISE = NoiseConfig(outliers=Outliers(enabled=True), rain=Rain(enabled=True), spray=Spray(enabled=True))
"""All kinds of noise with random draws; a ghost of the newcomer would be a point of its own."""
FAST = 20.0


def drive(*lane):
    return [Straight("straight", FAST), *lane]


NEWCOMER = ScriptedActor(-60.0, 30.0, name="newcomer", kind="van", motion=drive())
"""Behind the others as seen from the ego: it occludes none of them."""
OTHERS = [
    ScriptedActor(15.0, 0.0, name="ahead", motion=drive()),
    ScriptedActor(5.0, 4.0, name="beside", kind="suv", motion=drive()),
    ScriptedActor(-14.0, 0.0, name="behind", motion=drive()),
]


def scripted(actors):
    return ScriptedSource(ScriptedTraffic(ego=ScriptedEgo(motion=drive()), actor=actors), Path(), 200.0)


def scans(source, seed, count=10):
    """Yield frames with their scan and truth."""
    with closing(source):
        lidar = Lidar(RIG, NOISE, SensorConfig(), seed, source.reset(seed))
        for _ in range(count):
            frame = source.step()
            yield frame, *lidar.scan(frame)


def properties(frame, scan, truth):
    """Return size, paint, pose and all that was measured of each actor, by name."""
    actors = frame.actors
    found = {}
    for row, name in enumerate(actors.name.tolist()):
        on = truth.actor_id == actors.id[row]
        measured = (scan.points_ego, scan.unit, scan.layer, scan.echo, scan.echo_pulse_width, truth.cause, truth.part)
        found[name] = [
            actors.size[row], actors.reflectivity[row], actors.pose_world[row], *(column[on] for column in measured)
        ]  # fmt: skip
    return found


def assert_same(one, other, names):
    for name in names:
        for mine, theirs in zip(one[name], other[name], strict=True):
            np.testing.assert_array_equal(mine, theirs, err_msg=name)


@pytest.mark.parametrize("seed", [1, 2])
def test_a_scripted_newcomer_changes_no_other_actor(seed):
    """The newcomer is the first of the script, so that all others have other numbers."""
    names = [actor.name for actor in OTHERS]
    for alone, joined in zip(scans(scripted(OTHERS), seed), scans(scripted([NEWCOMER, *OTHERS]), seed), strict=True):
        before, after = properties(*alone), properties(*joined)
        assert_same(before, after, names)
        assert all(len(before[name][3]) > 20 for name in names), "each is measured"
        np.testing.assert_array_equal(alone[1].ego_pose_odom, joined[1].ego_pose_odom)
        assert not np.array_equal(alone[0].actors.id, joined[0].actors.id[np.isin(joined[0].actors.name, names)])


def test_a_renamed_actor_is_another_one():
    """Fails if the draws ignored the name."""
    renamed = [replace(OTHERS[0], name="other"), *OTHERS[1:]]
    ((*alone,), (*joined,)) = (next(scans(scripted(actors), 1)) for actors in (OTHERS, renamed))
    before, after = properties(*alone)["ahead"], properties(*joined)["other"]
    assert all(np.any(before[column] != after[column]) for column in (1, 2)), "paint and start"
    assert len(before[3]) != len(after[3]) or np.any(before[3] != after[3])


def routes(*vehicles):
    """Return a route file of vehicles (name, position, lane) that stand on the western arm of the crossing."""
    lines = [
        f'<vehicle id="{name}" type="calm" route="east" depart="0" departPos="{place}" departLane="{lane}">'
        f'<stop lane="west_in_{lane}" endPos="{place + 0.5}" duration="50"/></vehicle>'
        for name, place, lane in vehicles
    ]
    return f"<routes>{''.join(lines)}</routes>"


@pytest.fixture
def standing(tmp_path):
    """Return a function that makes a source of standing vehicles, from one or two route files."""
    calm = '<vType id="calm" sigma="0" speedFactor="1"/>'  # SUMO draws for its drivers from a common stream
    route = f'<routes>{calm}<route id="east" edges="west_in east_out"/></routes>'
    (tmp_path / "route.rou.xml").write_text(route)
    base = routes(("ego", 60, 1), ("front", 72, 1), ("left", 55, 2), ("rear", 45, 1))
    (tmp_path / "base.rou.xml").write_text(base)
    (tmp_path / "more.rou.xml").write_text(routes(("a_newcomer", 30, 1)))

    def make(*files):
        names = [f"{name}.rou.xml" for name in ("route", *files)]
        return SumoSource(SumoTraffic(net=str(CROSSING), routes=names, ego="vehicle:ego"), tmp_path, 150.0)

    return make


def test_another_vehicle_of_sumo_changes_no_other(standing):
    """The newcomer comes first by name, and stands behind the others as seen from the ego."""
    names = ["front", "left", "rear"]
    alone = list(scans(standing("base"), 1, count=4))
    joined = list(scans(standing("more", "base"), 1, count=4))
    for before, after in zip(alone, joined, strict=True):
        assert set(after[0].actors.name) == {*names, "a_newcomer"}
        one, other = properties(*before), properties(*after)
        assert_same(one, other, names)
        assert all(len(one[name][3]) > 20 for name in names)
        assert len({tuple(one[name][0]) for name in names}) == 3, "sizes are drawn"
    assert not np.array_equal(alone[0][0].actors.id, joined[0][0].actors.id[np.isin(joined[0][0].actors.name, names)])
