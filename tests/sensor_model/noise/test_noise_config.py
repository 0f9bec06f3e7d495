"""Noise configuration: one-line errors for invalid values, and documented defaults."""

from dataclasses import fields, replace

import pytest

from luxloop.sensor_model.noise import noise_config as noise
from luxloop.sensor_model.noise.noise_config import KINDS, NoiseConfig

NAN, INF = float("nan"), float("inf")


CAR = {"calibration", "attitude", "odometry"}
"""Errors of the car, as opposed to those of the LIDARs and the weather."""


def enabled(config):
    return {kind for kind in KINDS if getattr(config, kind).enabled}


def test_defaults_are_a_healthy_rig_and_car_on_a_dry_day():
    on = {"range", "dropout", "mirror", "ghost", "layer_overlap", "false_alarms"} | CAR
    assert enabled(NoiseConfig()) == on
    assert set(KINDS) - on == {"outage", "dirt", "sun", "outliers", "rain", "spray", "snow", "fog"}


def test_an_ideal_car_has_no_errors_of_its_own():
    assert enabled(NoiseConfig(ideal=True)) == enabled(NoiseConfig()) - CAR
    assert enabled(replace(NoiseConfig(), ideal=True)) == enabled(NoiseConfig()) - CAR


def test_tables_that_are_given_override_ideal():
    """Also a table equal to the default: the file asks for it."""
    assert enabled(NoiseConfig(ideal=True, attitude=noise.AttitudeNoise())) & CAR == {"attitude"}
    assert enabled(NoiseConfig(odometry=noise.OdometryNoise(enabled=False))) & CAR == CAR - {"odometry"}


@pytest.mark.parametrize(
    ("kind", "values", "pattern"),
    [
        (noise.RangeNoise, {"sigma_scale": -0.1}, "sigma_scale = -0.1: must not be negative; use 0"),
        (noise.RangeNoise, {"sigma_scale": NAN}, "sigma_scale = nan: must not be negative"),
        (noise.RangeNoise, {"layer_bias_scale": INF}, "layer_bias_scale = inf: must be finite"),
        (noise.Dropout, {"softness_db": -1.0}, "softness_db = -1.0: must be from 0, a hard threshold, to 20"),
        (noise.Dropout, {"random_rate": 1.5}, "random_rate = 1.5: must be from 0 to 1"),
        (noise.Outage, {"mean_uptime_s": 0.0}, "mean_uptime_s = 0.0: must be positive"),
        (noise.Outage, {"mean_outage_s": INF}, "mean_outage_s = inf: must be positive and finite"),
        (noise.FixedOutage, {"unit": "a", "from_s": 2.0, "to_s": 2.0}, "to_s = 2.0: must be after from_s = 2.0"),
        (noise.DirtSector, {"unit": "a", "from_deg": 5.0, "to_deg": 0.0}, "to_deg = 0.0: must be above from_deg = 5.0"),
        (
            noise.DirtSector,
            {"unit": "a", "from_deg": 170.0, "to_deg": 190.0},
            "to_deg = 190.0: must be from -180 to 180; split a sector that crosses the rear",
        ),
        (noise.DirtSector, {"unit": "a", "from_deg": -181.0, "to_deg": 0.0}, "from_deg = -181.0: must be from -180"),
        (
            noise.DirtSector,
            {"unit": "a", "from_deg": 0.0, "to_deg": 5.0, "transmission": 1.1},
            "transmission = 1.1: must be from 0",
        ),
        (noise.Dirt, {"enabled": True, "sectors": ()}, r"sectors = \[\]: .* name at least one sector"),
        (noise.Sun, {"azimuth_deg": NAN}, "azimuth_deg = nan: must be from -360 to 360"),
        (noise.Sun, {"half_width_deg": 0.0}, "half_width_deg = 0.0: must be above 0"),
        (noise.Sun, {"gain": 0.0}, "gain = 0.0: must be above 0 and at most 1; use an outage"),
        (noise.Ghost, {"glass_quality": 1.2}, "glass_quality = 1.2: must be from 0"),
        (noise.Ghost, {"paint_quality": -0.2}, "paint_quality = -0.2: must be from 0"),
        (noise.CalibrationError, {"yaw_sigma_deg": 11.0}, "yaw_sigma_deg = 11.0: must be from 0 to 10"),
        (noise.CalibrationError, {"z_sigma_m": -1.0}, "z_sigma_m = -1.0: must be from 0 to 0.2"),
        (noise.CalibrationError, {"sync_sigma_ms": NAN}, "sync_sigma_ms = nan: must be from 0 to 20"),
        (noise.CalibrationError, {"doubled_beyond_m": 0.0}, "doubled_beyond_m = 0.0: must be positive"),
        (noise.AttitudeNoise, {"pitch_deg": 11.0}, "pitch_deg = 11.0: must be from -10 to 10"),
        (noise.AttitudeNoise, {"roll_sigma_deg": -1.0}, "roll_sigma_deg = -1.0: must be from 0 to 5"),
        (
            noise.AttitudeNoise,
            {"pitch_deg": -6.0, "pitch_sigma_deg": 1.5},
            r"pitch_sigma_deg = 1.5: \|pitch_deg\| \+ 3 sigma must be at most 10; lower one of them",
        ),
        (noise.AttitudeNoise, {"roll_sigma_deg": 3.5}, r"roll_sigma_deg = 3.5: \|roll_deg\| \+ 3 sigma must be"),
        (noise.AttitudeNoise, {"full_from_mps": -1.0}, "full_from_mps = -1.0: must be from 0 to 100"),
        (noise.AttitudeNoise, {"fastest_hz": 0.5}, "fastest_hz = 0.5: must be above slowest_hz"),
        (noise.OdometryNoise, {"speed_scale_sigma": 0.2}, "speed_scale_sigma = 0.2: must be from 0 to 0.1"),
        (noise.OdometryNoise, {"yaw_walk_sigma_deg": -1.0}, "yaw_walk_sigma_deg = -1.0: must be from 0 to 2"),
        (noise.Outliers, {"rate": -0.1}, "rate = -0.1: must be from 0 to 1"),
        (noise.Outliers, {"scale_m": 0.0}, "scale_m = 0.0: must be above 0 and at most 50; use rate = 0"),
        (noise.Outliers, {"scale_m": 1e6}, "scale_m = 1000000.0: must be above 0 and at most 50"),
        (noise.FalseAlarms, {"rate": 0.0}, "rate = 0.0: must be above 0 and at most 1; use enabled = false"),
        (noise.Rain, {"rate_mm_per_h": 0.0}, "rate_mm_per_h = 0.0: must be above 0"),
        (noise.Rain, {"drops_per_mm_per_h": 1.0}, "drops_per_mm_per_h = 1.0: times rate_mm_per_h must be 0 to 1"),
        (noise.Rain, {"range_log_mean": NAN}, "range_log_mean = nan: must be from -5 to 5"),
        (noise.Rain, {"range_log_mean": 1000.0}, "range_log_mean = 1000.0: must be from -5 to 5"),
        (noise.Rain, {"range_log_sigma": 0.0}, "range_log_sigma = 0.0: must be above 0 and at most 5"),
        (noise.Rain, {"labelled": 2.0}, "labelled = 2.0: must be from 0 to 1"),
        (noise.Spray, {"water_film_mm": 0.0}, "water_film_mm = 0.0: must be above 0"),
        (noise.Spray, {"echo_share": 0.0}, "echo_share = 0.0: must be above 0 and at most 1"),
        (noise.Spray, {"reach_m": INF}, "reach_m = inf: must be above 0 and at most 200"),
        (noise.Spray, {"labelled": -1.0}, "labelled = -1.0: must be from 0 to 1"),
        (noise.Snow, {"rate_mm_per_h": 10.1}, "rate_mm_per_h = 10.1: must be above 0 and at most 10"),
        (noise.Snow, {"labelled": NAN}, "labelled = nan: must be from 0 to 1"),
        (noise.Fog, {"visibility_m": 19.9}, "visibility_m = 19.9: must be from 20 to 10000"),
        (noise.Fog, {"labelled": 1.1}, "labelled = 1.1: must be from 0 to 1"),
    ],
)
def test_value_out_of_range_is_refused(kind, values, pattern):
    with pytest.raises(ValueError, match=pattern) as caught:
        kind(**values)
    assert "\n" not in str(caught.value)


def test_every_kind_with_strengths_has_a_case_above():
    """Fails if a kind of noise is added without validated values."""
    kinds = {type(getattr(NoiseConfig(), kind)) for kind in KINDS}
    with_strengths = {kind for kind in kinds if len(fields(kind)) > 1}
    marks = test_value_out_of_range_is_refused.pytestmark
    assert with_strengths <= {case[0] for mark in marks for case in mark.args[1]}
