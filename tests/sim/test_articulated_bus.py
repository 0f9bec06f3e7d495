"""Articulated buses: dimensions, motion in a turn, bodies at an angle, and traffic of SUMO."""

import math
from contextlib import closing

import numpy as np
import pytest
from support.paths import NETS
from support.sensor_scenes import ActorSpec, world
from support.solid_mesh import corners, pieces

from luxloop.scenarios.grading.articulated import parts
from luxloop.sensor_model.bodies.materials import Glass
from luxloop.sensor_model.bodies.scene import BodyFactory
from luxloop.sensor_model.truth import Part
from luxloop.sim.articulation import hitch
from luxloop.sim.kinematics import RawFrame
from luxloop.sim.physical.layer import PhysicalTruth
from luxloop.sim.physical.physical_config import PhysicalConfig
from luxloop.sim.roster import Member
from luxloop.sim.sumo.sumo_config import SumoTraffic
from luxloop.sim.sumo.sumo_source import SumoSource
from luxloop.sim.world import JOINTS, Kind

LENGTH, WIDTH, HEIGHT = 18.125, 2.55, 3.1
MIDDLE_AXLE, JOINT, REAR_AXLE = 8.705, 10.455, 14.695
"""Behind the front bumper [m]: a Mercedes-Benz Citaro G; the joint is an estimate."""
BUS = np.array([Kind.BUS], np.uint8)


def test_the_dimensions_are_those_of_the_data_sheet_and_fit_the_swept_ring_of_the_directive():
    """96/53/EC, annex I, 1.5: with the front's outer corner on 12.50 m, no part is within 5.30 m of the centre."""
    places = hitch(np.array([LENGTH]), BUS)
    assert np.ravel(places) == pytest.approx([JOINT, JOINT, MIDDLE_AXLE, REAR_AXLE])
    middle = math.sqrt(12.5**2 - MIDDLE_AXLE**2) - WIDTH / 2
    rear = math.sqrt(middle**2 + (JOINT - MIDDLE_AXLE) ** 2 - (REAR_AXLE - JOINT) ** 2)
    assert rear - WIDTH / 2 > 5.30


@pytest.mark.parametrize("radius", [15.0, 20.0, 40.0])
def test_the_rear_part_follows_the_hand_formula_of_the_kinematic_trailer(radius):
    """Steady turn: axles stand square to the radius, so Pythagoras gives the radii of joint and rear axle (Jindra,
    "Off-tracking of tractor-trailer combinations", Automobile Engineer 53, 1963)."""
    bus = Member(1, "bus", Kind.BUS, (LENGTH, WIDTH, HEIGHT), 0.5)
    speed, dt, count = 4.0, 0.08, 500
    layer, out = PhysicalTruth(dt, PhysicalConfig(smoothing_s=0.0), rolling=True), []
    for k in range(count):
        turn = speed * dt * k / radius
        yaw = turn + math.pi / 2 - math.asin(0.5 * MIDDLE_AXLE / radius)  # any yaw near the course will do
        front = radius * np.array([math.cos(turn), math.sin(turn)])
        centre = front - 0.5 * LENGTH * np.array([math.cos(yaw), math.sin(yaw)])
        layer.push(RawFrame([bus], np.array([[*centre, yaw]]), np.array([speed])))
        while (settled := layer.pop()) is not None:
            out.append(settled[1])
    x, y, yaw = out[-1].pose_world[0]
    ahead = 0.5 * LENGTH - REAR_AXLE
    middle = math.sqrt(radius**2 - MIDDLE_AXLE**2)
    joint = math.hypot(middle, JOINT - MIDDLE_AXLE)
    rear = math.sqrt(joint**2 - (REAR_AXLE - JOINT) ** 2)
    assert math.hypot(x + ahead * math.cos(yaw), y + ahead * math.sin(yaw)) == pytest.approx(rear, abs=0.1)
    bend = math.atan((REAR_AXLE - JOINT) / rear) + math.atan((JOINT - MIDDLE_AXLE) / middle)
    assert out[-1].articulation[0] == pytest.approx(bend, abs=0.01)


def body(length, articulation, *, plain=False, seed=None):
    bus = ActorSpec(0.0, 0.0, 0.0, Kind.BUS, articulation=articulation, size=(length, WIDTH, HEIGHT))
    return pieces(BodyFactory(mirrors=True, plain=plain, glass=Glass(), seed=seed).place(world(bus)), 0)


@pytest.mark.parametrize("plain", [False, True])
@pytest.mark.parametrize("angle", [0.6, -0.9])
@pytest.mark.parametrize("seed", [None, 3])
def test_the_front_part_turns_about_the_joint_and_the_rear_part_stays(plain, angle, seed):
    straight, bent = body(LENGTH, 0.0, plain=plain, seed=seed), body(LENGTH, angle, plain=plain, seed=seed)
    joint, turned = LENGTH / 2 - JOINT, 0
    for before, after in zip(straight, bent, strict=True):
        old, new = corners(before.planes), corners(after.planes)
        if not before.tractor:
            assert np.array_equal(before.planes, after.planes)
            assert old[:, 0].max() <= joint + 1e-6
            continue
        turned += 1
        assert old[:, 0].min() >= joint - 1e-6
        plan = (old[:, 0] + 1j * old[:, 1] - joint) * np.exp(1j * angle) + joint
        away = np.abs(plan[:, None] - (new[:, 0] + 1j * new[:, 1])).min(axis=1)
        assert away.max() < 1e-6
    assert 0 < turned < len(straight)


def test_an_articulated_bus_has_three_axles_and_other_lengths_of_the_kind_have_no_joint():
    wheels = [solid for solid in body(LENGTH, 0.0) if solid.part[0] == Part.WHEEL]
    at = sorted({round(LENGTH / 2 - corners(wheel.planes)[:, 0].mean(), 2) for wheel in wheels})
    assert len(wheels) == 6
    assert at[1] == pytest.approx(MIDDLE_AXLE, abs=0.05)
    assert at[2] == pytest.approx(REAR_AXLE, abs=0.4)
    for length in (12.0, 15.0):  # trams and trains, which are longer, have sections: test_sections.py
        assert not any(solid.tractor for solid in body(length, 0.0))


def test_the_boxes_of_a_bent_bus_meet_at_the_joint():
    pose, size = np.array([[10.0, 5.0, 0.4]]), np.array([[LENGTH, WIDTH]])
    row, poses, sizes = parts(pose, size, np.pad([[0.5]], ((0, 0), (0, JOINTS - 1))), BUS)
    assert row.tolist() == [0, 0]
    assert sizes[:, 0] == pytest.approx([LENGTH - JOINT, JOINT])
    heading = np.column_stack([np.cos(poses[:, 2]), np.sin(poses[:, 2])])
    assert poses[0, :2] + 0.5 * sizes[0, 0] * heading[0] == pytest.approx(poses[1, :2] - 0.5 * sizes[1, 0] * heading[1])
    assert poses[:, 2] == pytest.approx([0.4, 0.9])


def test_sumo_s_long_buses_bend_in_a_turn(tmp_path):
    lengths = {"solo": 12.0, "long": 18.0}
    (tmp_path / "t.rou.xml").write_text(
        "<routes>"
        + "".join(
            f'<vType id="t{name}" vClass="bus" length="{length}" sigma="0"/>'
            f'<trip id="{name}" type="t{name}" depart="{5 * k}" departPos="last" from="r20" to="hairpin"/>'
            for k, (name, length) in enumerate(lengths.items())
        )
        + '<trip id="ego" depart="16" from="r20" to="hairpin"/></routes>'
    )
    config = SumoTraffic(net=str(NETS / "winding/winding.net.xml"), routes=["t.rou.xml"], ego="vehicle:ego")
    largest = dict.fromkeys(lengths, 0.0)
    with closing(SumoSource(config, tmp_path, 300.0)) as source:
        source.reset(1)
        for _ in range(150):
            actors = source.step().actors
            for name, bend, acceleration in zip(
                actors.name, actors.articulation, actors.acceleration_world, strict=True
            ):
                largest[str(name)] = max(largest[str(name)], abs(float(bend)))
                assert np.hypot(*acceleration) < 10.0
    assert largest["long"] > 0.2
    assert largest["solo"] == 0.0
