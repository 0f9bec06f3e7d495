"""Kernels that move and label echoes on bodies, against slow reference implementations."""

from dataclasses import fields, replace

import numpy as np
import pytest
from support import naive_labels
from support.sensor_scenes import FOOTPRINT, LUX_RIG, ActorSpec, placed_scene, world

from luxloop.sensor_model.noise.calibration import CalibrationError, true_mounts
from luxloop.sensor_model.noise.random_draws import Draws
from luxloop.sensor_model.raycaster import Raycaster, displace
from luxloop.sensor_model.scan_context import displacement
from luxloop.sensor_model.truth import Cause, Face, Part
from luxloop.sensor_model.visibility import MAX_CLEAN_DEPTH, from_surfaces, visible_faces
from luxloop.sim.world import Kind

EGO = ActorSpec(0.0, 0.0, velocity=(9.0, 0.5), yaw_rate=0.3)
STREET = (
    ActorSpec(9.0, 3.2, 0.2, velocity=(12.0, -1.0), yaw_rate=-0.4),
    ActorSpec(-8.0, -4.0, np.pi, kind=Kind.VAN, velocity=(-7.0, 0.0)),
    ActorSpec(3.0, 9.0, 1.2, kind=Kind.MOTORCYCLE),
)
BENT = ActorSpec(16.0, -7.0, 2.6, kind=Kind.TRAILER_TRUCK, velocity=(-3.0, 2.0), articulation=0.35)


def cast(*specs):
    """Return beams, bodies, context and echoes of a street."""
    frame = world(*specs, ego=EGO)
    beams, bodies, walls, context = placed_scene(
        LUX_RIG, FOOTPRINT, frame, time_jitter=np.linspace(-0.004, 0.006, len(LUX_RIG.mounts))
    )
    return beams, bodies, context, Raycaster(beams, FOOTPRINT).cast(bodies, walls, context), frame.actors.size


def test_echoes_move_to_the_relief_of_fronts_and_rears():
    _, bodies, _, echoes, _ = cast(*STREET, BENT)
    moved = displace(echoes, bodies, 1.5)
    on = np.flatnonzero(echoes.target >= 0)
    shift = moved.range - echoes.range
    expected = [
        naive_labels.relief_shift(
            bodies, echoes.target[e], echoes.surface[e], echoes.point_body[e], echoes.direction_body[e], 1.5
        )
        for e in on
    ]
    np.testing.assert_allclose(shift[on], expected, atol=1e-12)
    assert np.abs(shift[on]).max() > 0.03
    assert np.any(bodies.plane_turn[echoes.surface[on]][np.abs(shift[on]) > 0.0] != 0.0)
    assert not shift[echoes.target < 0].any()
    along = np.sum((moved.point_body - echoes.point_body) * echoes.direction_body, axis=1)
    np.testing.assert_allclose(along, shift, atol=1e-12)


def test_no_relief_leaves_the_echoes_unchanged():
    _, bodies, _, echoes, _ = cast(*STREET)
    assert displace(echoes, bodies, 0.0) is echoes


def test_calibration_errors_displace_points_on_actors():
    """True less nominal mount, and the motion of the actor's surface past the ego in the delay of the firing."""
    beams, bodies, context, echoes, _ = cast(*STREET, BENT)
    returns = from_surfaces(echoes, bodies)
    origin, rotation = true_mounts(CalibrationError(), beams.units, Draws(4, beams))
    found = displacement(returns, beams, (origin, rotation), bodies, context)
    assert not found[returns.target < 0].any()
    for i in np.flatnonzero(returns.target >= 0):
        unit, direction = beams.unit[returns.beam[i]], beams.direction_ego[returns.beam[i]]
        nominal, turn = beams.units.origin_ego[unit], rotation[unit] @ beams.units.R_ego_unit[unit].T
        point = nominal + returns.range[i] * direction
        shift = origin[unit] + returns.range[i] * turn @ direction - point
        passed = naive_labels.surface_velocity(
            bodies, returns.target[i], point[:2], context.ego_velocity, context.ego_yaw_rate
        )
        shift[:2] += context.time_jitter[unit] * passed
        assert found[i] == pytest.approx(np.linalg.norm(shift), abs=1e-7)


def test_causes_and_faces_follow_from_the_outline_of_the_straight_body():
    beams, bodies, context, echoes, size = cast(*STREET, BENT)
    echoes = displace(echoes, bodies, 1.0)
    outlines = naive_labels.outlines(cast(*STREET, ActorSpec(16.0, -7.0, kind=Kind.TRAILER_TRUCK))[1])
    returns, unit = from_surfaces(echoes, bodies), beams.unit[echoes.beam]
    counted = np.zeros((len(bodies), 4), dtype=int)
    for i in np.flatnonzero(returns.target >= 0):
        actor, plane = returns.target[i], returns.surface[i]
        point = naive_labels.straight(bodies, plane, echoes.point_body[i])
        np.testing.assert_allclose(returns.point_body[i], point, atol=1e-12)
        depth, _ = naive_labels.depth_and_normal(outlines[actor], point)
        expected = Cause.LAYER_OVERLAP if depth > MAX_CLEAN_DEPTH else Cause.CLEAN
        assert returns.cause[i] == (Cause.MIRROR if returns.part[i] == Part.MIRROR else expected)
        if returns.cause[i] == Cause.CLEAN:
            lidar = context.origin_ego[unit[i]]
            counted[actor] += naive_labels.faces_of(bodies, actor, plane, outlines[actor], point, lidar, size[actor])
    faces = visible_faces(returns, unit, context.origin_ego, bodies, size)
    assert np.array_equal(faces, (counted >= 3) @ [1, 2, 4, 8])
    assert {Cause.CLEAN, Cause.LAYER_OVERLAP} <= set(returns.cause[returns.target >= 0])


def test_a_face_is_visible_from_three_points_on():
    beams, bodies, context, echoes, size = cast(ActorSpec(16.0, 0.0))
    returns = from_surfaces(echoes, bodies)

    def seen_by(rows):
        kept = replace(returns, **{field.name: getattr(returns, field.name)[rows] for field in fields(returns)})
        return Face(visible_faces(kept, beams.unit[kept.beam], context.origin_ego, bodies, size)[0])

    on_rear = [row for row in np.flatnonzero(returns.target == 0) if seen_by(np.full(20, row)) == Face.REAR]
    assert [seen_by(np.array(on_rear[:points])) for points in (2, 3, 4)] == [Face(0), Face.REAR, Face.REAR]
