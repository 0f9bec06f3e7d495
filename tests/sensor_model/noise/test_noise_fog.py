"""Fog: extinction, echoes near the unit, and lost beams, against figures computed by hand."""

import numpy as np
import pytest
from support.noise_scenes import BEAMS, healthy, thresholds, within
from support.sensor_scenes import CENTRE_RAY, one_unit_rig, scan, small_unit, walls

from luxloop.sensor_model.noise.fog import FogEchoes, extinction
from luxloop.sensor_model.noise.noise_config import Dirt, DirtSector, Dropout, Fog, NoiseConfig
from luxloop.sensor_model.noise.random_draws import Draws
from luxloop.sensor_model.rig.unit import Fan
from luxloop.sensor_model.truth import Cause, Loss, Part

FRAMES = 20


def plain(**kinds):
    """Return noise without losses and errors but those given."""
    return NoiseConfig(ideal=True, dropout=Dropout(enabled=False), **kinds)


def fog_of(visibility_m, need=None, frames=FRAMES):
    """Return the beams and ranges of the echoes of some frames of fog."""
    fog = FogEchoes(Fog(True, visibility_m=visibility_m), BEAMS)
    some = [fog.draw(need or healthy(), Draws(2, BEAMS), frame) for frame in range(frames)]
    assert all(np.all(each.cause == Cause.FOG) and np.all(each.part == Part.DROPLET) for each in some)
    return np.concatenate([each.beam for each in some]), np.concatenate([each.range for each in some])


def test_visibility_is_where_five_percent_of_the_light_is_left():
    """Meteorological optical range of the WMO: exp(-alpha V) = 0.05."""
    assert np.exp(-50.0 * extinction(Fog(True, visibility_m=50.0))) == pytest.approx(0.05, rel=1e-12)
    assert extinction(Fog(True, visibility_m=1000.0)) == pytest.approx(2.9957e-3, rel=1e-4)
    assert extinction(Fog()) == 0.0


@pytest.mark.parametrize(
    ("visibility_m", "reflectivity", "range_m"),
    [(50.0, 0.1, 17.511), (50.0, 0.9, 28.009), (100.0, 0.1, 24.210), (200.0, 0.1, 31.291)],
)
def test_plate_is_lost_where_fog_leaves_it_below_the_threshold(visibility_m, reflectivity, range_m):
    """rho / r^2 exp(-2 ln(20) r / V) = 0.1 / (50 m)^2, solved by hand. In clear air 10 % is lost at 50 m."""
    unit = small_unit((Fan((0,), 0.25, -0.25, 0.5, (100.0,)),), (0.0,), reference_reflectivity=0.1,
                      reference_range_m=50.0, range_min_m=0.3)  # fmt: skip
    noise = plain(fog=Fog(True, visibility_m=visibility_m))
    for offset, visible in ((-0.02, True), (0.02, False)):
        at = range_m + offset
        plate = walls(((at, -5.0), (at, 5.0)), height=5.0, reflectivity=reflectivity)
        _, truth = scan(noise=noise, sensor=CENTRE_RAY, obstacles=plate, rig=one_unit_rig(unit))
        assert (Part.OBSTACLE in truth.part) == visible
        assert set(truth.lost_cause) == (set() if visible else {Loss.AIR})


@pytest.mark.parametrize(("visibility_m", "least", "most"), [(50.0, 0.4, 0.5), (100.0, 0.15, 0.2), (300.0, 0.0, 0.005)])
def test_dense_fog_has_echoes_just_beyond_the_near_range(visibility_m, least, most):
    """A LUX at 5.34 m and 50 m of visibility: pi 0.046 / 50 0.675 / 5.34^2 exp(-0.64) = 3.61e-5 / m^2, 0.90 times the
    threshold, which a lognormal of 0.5 exceeds with the probability 0.42 at full gain."""
    beam, range_ = fog_of(visibility_m)
    assert least < len(beam) / (FRAMES * len(BEAMS)) < most
    assert range_.min() >= 5.0
    assert range_.max() < 12.0
    first = np.isin(beam, np.flatnonzero(BEAMS.gain == 1.0)) & (range_ < 5.675)
    if visibility_m == 50.0:
        assert within(np.count_nonzero(first), FRAMES * np.count_nonzero(BEAMS.gain == 1.0), 0.419)


def test_blocked_window_sees_no_fog():
    blocked = Dirt(True, (DirtSector("*", -180.0, 180.0, transmission=0.0),))
    assert len(fog_of(50.0, thresholds(plain(dirt=blocked)))[0]) == 0


def test_surfaces_hide_the_fog_behind_them():
    """Walls nearer than the echoes of fog leave few of them, in corners only; walls behind them leave all."""
    noise = plain(fog=Fog(True, visibility_m=50.0))
    for at, some in ((5.0, False), (14.0, True)):
        room = walls(((-at, -at), (at, -at), (at, at), (-at, at)), height=6.0)
        _, truth = scan(noise=noise, obstacles=room)
        assert (np.count_nonzero(truth.cause == Cause.FOG) > 100) == some
