"""Snow: extinction, share and ranges of the flakes, against published figures."""

import numpy as np
import pytest
import scipy
from support.noise_scenes import BEAMS, healthy, within
from support.sensor_scenes import CENTRE_RAY, scan, walls

from luxloop.sensor_model.noise.noise_config import NoiseConfig, Snow
from luxloop.sensor_model.noise.random_draws import Draws
from luxloop.sensor_model.noise.snow import extinction, flakes
from luxloop.sensor_model.truth import Cause, Part
from luxloop.tracker.scan import PointFlag


def test_extinction_is_that_of_dry_snow():
    """ITU-R P.1817: (5.42e-5 x 905 + 5.4959) R^1.38 = 5.545 dB per kilometre at 1 mm/h, 19.6 at 2.5 mm/h."""
    assert np.exp(-1000 * extinction(Snow(True, rate_mm_per_h=1.0))) == pytest.approx(10**-0.5545, rel=2e-3)
    assert np.exp(-1000 * extinction(Snow(True, rate_mm_per_h=2.5))) == pytest.approx(10**-1.963, rel=5e-3)
    assert extinction(Snow()) == 0.0


def test_flakes_have_their_share_and_lognormal_ranges():
    """0.01569 per mm/h, log range 1.4329 +- 0.7868 (TU Darmstadt's fit to a VLP-16); half of them labelled."""
    snow = Snow(True, rate_mm_per_h=2.0)
    some = [flakes(snow, BEAMS, healthy(), Draws(2, BEAMS), frame) for frame in range(40)]
    ranges = np.concatenate([each.range for each in some])
    assert within(len(ranges), 40 * len(BEAMS), 0.01569 * 2)
    assert scipy.stats.kstest(ranges, scipy.stats.lognorm(s=0.7868, scale=np.exp(1.4329)).cdf).pvalue > 1e-3
    flags = np.concatenate([each.flags for each in some])
    assert within(np.count_nonzero(flags == PointFlag.CLUTTER), len(flags), 0.5)


def test_flakes_are_points_of_a_scan_and_snow_reaches_the_ray_caster():
    """A dark wall that is just seen in clear air is lost to heavy snow, and flakes are seen instead."""
    room = walls(((-45, -45), (45, -45), (45, 45), (-45, 45)), height=9.0, reflectivity=0.12)
    kinds = {"ideal": True}
    _, clear = scan(noise=NoiseConfig(**kinds), sensor=CENTRE_RAY, obstacles=room)
    _, snowing = scan(noise=NoiseConfig(snow=Snow(True, rate_mm_per_h=5.0), **kinds), sensor=CENTRE_RAY, obstacles=room)
    assert np.count_nonzero(clear.part == Part.OBSTACLE) > 500
    assert np.count_nonzero(snowing.part == Part.OBSTACLE) < 50
    flakes_seen = snowing.cause == Cause.SNOW
    assert within(np.count_nonzero(flakes_seen), len(BEAMS), 0.01569 * 5)
    assert set(snowing.part[flakes_seen]) == {Part.DROPLET}
