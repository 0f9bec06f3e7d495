"""Ghosts in a plane mirror, against values computed by hand."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from support.naive_noise import mirrored_ray, moved
from support.noise_scenes import ALL, BEAMS, context, returns

from luxloop.sensor_model.bodies.materials import Glass
from luxloop.sensor_model.bodies.scene import BodyFactory
from luxloop.sensor_model.kernels.mirrors import bright_mirrors
from luxloop.sensor_model.kernels.records import BeamAxes, EgoDrive, MovingPlanes, Reflectance, SurfaceHits, UnitPoses
from luxloop.sensor_model.noise.ghosts import Mirrored, Mirrors
from luxloop.sensor_model.noise.noise_config import Ghost
from luxloop.sensor_model.truth import Cause, Part
from luxloop.sim.world import Actors, Ego, Kind, WorldFrame

PERFECT = Ghost(glass_quality=1.0, paint_quality=1.0)
NOW = np.zeros(len(BEAMS))
WALL_X, FLANK_Y = 20.0, 2.0
"""A truck's flank, 2 m to the left of the ego's centre and facing right, and a wall ahead of both."""


def trucks():
    actors = Actors(
        id=np.array([5]),
        name=np.array(["truck"]),
        kind=np.array([Kind.TRUCK], np.uint8),
        pose_world=np.array([[8.0, FLANK_Y + 1.25, 0.0]]),
        velocity_world=np.zeros((1, 2)),
        acceleration_world=np.zeros((1, 2)),
        yaw_rate=np.zeros(1),
        articulation=np.zeros(1),
        mode=np.zeros(1, np.uint8),
        changes_lane=np.zeros(1, np.bool_),
        deviation=np.zeros((1, 2)),
        ground_z=np.zeros(1),
        attitude=np.zeros((1, 2)),
        size=np.array([[20.0, 2.5, 4.0]]),
        reflectivity=np.array([0.4]),
    )
    ego = Ego(
        np.zeros(3), np.zeros(2), np.zeros(2), 0.0, np.array([4.83, 1.91, 1.67]), False, np.zeros(2), 0.0, np.zeros(2)
    )
    return BodyFactory(mirrors=False, plain=True, glass=Glass(), seed=None).place(WorldFrame(0, 0.0, ego, actors))


TRUCK = trucks()
FLANK = int(np.flatnonzero(TRUCK.planes[:, 1] < -0.999)[0])


def on_flank(part=Part.BODY, surface=FLANK):
    """Return the returns of the front left unit from the flank, at 6 to 30 degrees to the left of straight ahead."""
    azimuth_deg = np.rad2deg(np.arctan2(*BEAMS.direction_ego[:, 1::-1].T))
    beam = np.flatnonzero((BEAMS.unit == 0) & (azimuth_deg > 6.0) & (azimuth_deg < 30.0))
    some = returns(beam, (FLANK_Y - BEAMS.units.origin_ego[0, 1]) / BEAMS.direction_ego[beam, 1])
    count = len(beam)
    return replace(
        some,
        target=np.zeros(count, np.int64),
        surface=np.full(count, surface),
        part=np.full(count, part, np.uint8),
    )


def wall(beam, origin, direction, _reach):
    """Cast against an unlimited wall of reflectivity 0.8."""
    assert len(beam) == len(origin) == len(direction)
    ahead = direction[:, 0] > 0.0
    range_ = np.where(ahead, (WALL_X - origin[:, 0]) / np.where(ahead, direction[:, 0], 1.0), np.inf)
    return Mirrored(range=range_, reflectivity=np.full(len(beam), 0.8), cosine=np.abs(direction[:, 0]))


def no_hit(beam, _origin, _direction, _reach):
    return Mirrored(np.full(len(beam), np.inf), np.zeros(len(beam)), np.zeros(len(beam)))


def seen(config=PERFECT, some=None, cast=wall, **circumstances):
    some = on_flank() if some is None else some
    return Mirrors(config, BEAMS).ghosts(some, TRUCK, context(**circumstances), NOW, cast)


@given(seed=st.integers(0, 2**32 - 1))
def test_bright_mirrors_equal_reference_implementation(seed):
    """Ego and bodies move and turn while the beams fire; only mirrors that are bright enough are found."""
    rng = np.random.default_rng(seed)
    count, bodies = 60, 4
    beam = np.sort(rng.choice(ALL, count, replace=False))
    range_, target = rng.uniform(2, 60, count), rng.integers(-3, bodies, count)
    surface, part = rng.integers(0, 8, count), rng.integers(0, 2, count).astype(np.uint8)
    pose, yaw_rate = rng.uniform(-3, 3, (bodies, 3)), rng.uniform(-2, 2, bodies)
    planes = rng.normal(size=(8, 4))
    planes[:, :3] /= np.linalg.norm(planes[:, :3], axis=1, keepdims=True)
    f0, quality = np.array([0.04, 0.08]), np.array([0.3, 0.9])
    drive, time = rng.uniform(-9, 9, 5), rng.uniform(-0.04, 0.04, len(BEAMS))
    direction, threshold = rng.normal(size=(len(BEAMS), 3)), np.full(len(BEAMS), 4e-5)
    direction /= np.linalg.norm(direction, axis=1, keepdims=True)
    units = BEAMS.units
    row, ray = bright_mirrors(
        SurfaceHits(beam, range_, target, surface, part), MovingPlanes(pose, yaw_rate, planes),
        Reflectance(f0, quality), UnitPoses(units.origin_ego, units.R_ego_unit), EgoDrive(*drive),
        BeamAxes(BEAMS.unit, BEAMS.index, direction, time), BEAMS.gain, threshold,
    )  # fmt: skip
    expected = {}
    for i in range(count):
        b, t, unit = beam[i], time[beam[i]], BEAMS.unit[beam[i]]
        if target[i] < 0:
            continue
        start = moved(units.origin_ego[unit], drive[4] * t, drive[:2] * t + drive[2:4] * t**2 / 2)
        heading = moved(units.R_ego_unit[unit] @ direction[b], drive[4] * t)
        normal = moved(planes[surface[i], :3], pose[target[i], 2] + yaw_rate[target[i]] * t)
        ray_on = mirrored_ray(start + range_[i] * heading, heading, normal, f0[part[i]], quality[part[i]])
        if ray_on is not None and ray_on[6] ** 2 * BEAMS.gain[b] / range_[i] ** 2 >= 4e-5:
            expected[i] = ray_on
    assert row.tolist() == list(expected)
    np.testing.assert_allclose(ray, np.reshape(list(expected.values()), (-1, 7)), atol=1e-9)


@pytest.mark.parametrize(
    ("part", "f0"), [(Part.BODY, 0.04), (Part.GREENHOUSE, 0.08), (Part.MIRROR, None), (Part.WHEEL, None)]
)
def test_schlick_reflectance_has_textbook_values(part, f0):
    """Index 1.5: 4 % per face at normal incidence, all at grazing incidence; at 60 deg 0.04 + 0.96 / 32 = 0.07."""
    shares = []
    for incidence_deg in (0.0, 60.0, 89.999):
        # A beam straight ahead of unit 0 and a plane at this angle to it.
        beam = int(np.flatnonzero(BEAMS.unit == 0)[200])
        heading = BEAMS.direction_ego[beam]
        aside = np.cross(heading, [0.0, 0.0, 1.0])
        aside /= np.linalg.norm(aside)
        normal = -np.cos(np.deg2rad(incidence_deg)) * heading + np.sin(np.deg2rad(incidence_deg)) * aside
        tilted = replace(TRUCK, planes=np.array([[*normal, 0.0]]))
        some = returns([beam], [1.0])
        some = replace(
            some, target=np.zeros(1, np.int64), surface=np.zeros(1, np.int64), part=np.array([part], np.uint8)
        )
        result = Mirrors(PERFECT, BEAMS).ghosts(
            some, tilted, context(), NOW, lambda beam, *_: Mirrored(*np.ones((3, len(beam))))
        )
        # F^2 gain / (1 + 1)^2
        shares += np.sqrt(result.power * 4 / BEAMS.gain[beam]).tolist()
    assert shares == pytest.approx([] if f0 is None else [f0, f0 + (1 - f0) / 32, 1.0], rel=1e-3)


def test_ghost_is_a_mirror_image():
    """The mirror image of the wall x = 20 in the flank y = 2 lies behind the flank, and so do the ghosts."""
    result = seen()
    assert len(result) > 20
    place = BEAMS.units.origin_ego[0] + result.range[:, None] * BEAMS.direction_ego[result.beam]
    assert place[:, 0] == pytest.approx(WALL_X, abs=1e-2)
    assert np.all(place[:, 1] > FLANK_Y)
    assert np.all(result.cause == Cause.GHOST)
    assert np.all(result.part == Part.NONE)


def test_threshold_applies_to_the_power_of_the_whole_path():
    """P = F^2 rho cos(t) gain / (r1 + r2)^2, computed here for the straight path to the wall behind the mirror."""
    some = on_flank()
    heading = BEAMS.direction_ego[some.beam]
    reflectance = 0.04 + 0.96 * (1.0 - heading[:, 1]) ** 5
    way = (WALL_X - BEAMS.units.origin_ego[0, 0]) / heading[:, 0]
    power = reflectance**2 * 0.8 * heading[:, 0] * BEAMS.gain[some.beam] / way**2
    visible = power >= 4e-5
    assert 20 < visible.sum() < len(visible) - 20
    result = seen(some=some)
    assert np.array_equal(result.beam, some.beam[visible])
    assert result.power == pytest.approx(power[visible], rel=1e-3)
    over_db = 10 * np.log10(power[visible] / 4e-5)
    assert result.width == pytest.approx(BEAMS.units.pulse_length[0] + BEAMS.units.pulse_growth[0] * over_db, abs=1e-3)


def test_rain_attenuates_ghosts_on_the_whole_path():
    """Fails if only one of the two legs, or one direction, is attenuated."""
    dry, wet = seen(), seen(extinction=1e-3)
    lost = np.exp(-2e-3 * dry.range)
    kept = dry.power * lost >= 4e-5
    assert np.array_equal(wet.beam, dry.beam[kept])
    assert wet.power == pytest.approx((dry.power * lost)[kept])


def test_poor_mirror_insensitive_unit_and_open_sky_give_no_ghost():
    assert len(seen(Ghost(paint_quality=0.01))) == 0
    assert len(seen(threshold=np.full(len(BEAMS), np.inf))) == 0
    assert len(seen(cast=no_hit)) == 0


def test_glass_reflects_more_than_paint():
    usual = Ghost()
    assert len(seen(usual, on_flank(Part.GREENHOUSE))) > len(seen(usual))


def test_surfaces_that_face_away_are_not_mirrors():
    far_side = int(np.flatnonzero(TRUCK.planes[:, 1] > 0.999)[0])
    assert len(seen(some=on_flank(surface=far_side))) == 0


def test_no_ghosts_without_returns():
    assert len(seen(some=returns([], []))) == 0
    on_ground = replace(on_flank(), target=np.full(len(on_flank()), -2))
    assert len(seen(some=on_ground)) == 0
