"""No field of a scan gives away the cause of a point: neither a constant nor a flag that never errs."""

import numpy as np
import pytest
from support.noise_scenes import BEAMS, healthy
from support.sensor_scenes import FOOTPRINT, LUX_RIG, ActorSpec, ahead, placed_scene, walls, world

from luxloop.sensor_model.lidar import Lidar
from luxloop.sensor_model.noise.false_alarms import false_alarms
from luxloop.sensor_model.noise.noise_config import FalseAlarms, Fog, NoiseConfig, Rain, Snow, Spray
from luxloop.sensor_model.noise.rain import drops
from luxloop.sensor_model.noise.random_draws import Draws
from luxloop.sensor_model.noise.ranging import echo_places, measure_widths
from luxloop.sensor_model.raycaster import Raycaster
from luxloop.sensor_model.truth import Cause
from luxloop.sim.world import Kind
from luxloop.tracker.scan import PointFlag

AIR = (Cause.FALSE_ALARM, Cause.RAIN, Cause.SPRAY, Cause.SNOW, Cause.FOG)
WET = NoiseConfig(
    rain=Rain(True, rate_mm_per_h=50.0), spray=Spray(True), false_alarms=FalseAlarms(rate=0.01, flagged=0.02)
)
WINTER = NoiseConfig(
    snow=Snow(True, rate_mm_per_h=2.5), fog=Fog(True, visibility_m=150.0), false_alarms=FalseAlarms(flagged=0.02)
)
STREET = (
    *(
        ahead(gap, y=y, paint=paint)
        for gap, y, paint in [(12, 0.0, 0.05), (25, 3.5, 0.4), (35, -3.5, 0.1), (50, 0, 0.2)]
    ),
    ahead(18.0, y=-3.5, kind=Kind.SUV, velocity=(30.0, 0.0)),
    ActorSpec(-14.0, 3.0, paint=0.05),
)
DARK = walls(
    *(((x, side), (x + 9.0, side)) for x in range(-80, 80, 10) for side in (-9.0, 9.0)), ((30, -40), (30, 40)),
    *(((x, side * (4.0 + 0.3 * (x % 16))), (x + 0.02, side * (4.0 + 0.3 * (x % 16))))
      for x in range(-40, 40) for side in (-1.0, 1.0)),
    height=6.0, reflectivity=0.05,
)  # fmt: skip
"""Dark walls with gaps, and thin pickets up to 5 m before them: where a beam hits both, their echoes merge."""
FRAMES = 12


@pytest.fixture(scope="module", params=[(WET, 0.01), (WINTER, 0.02)], ids=["rain", "winter"])
def drive(request):
    """Points of some frames of weather: fields of the scans by name, true if the point is from the air,
    and the largest share of those with a pulse width of their own."""
    noise, widest = request.param
    lidar = Lidar(LUX_RIG, noise, FOOTPRINT, 5, DARK)
    both = [lidar.scan(world(*STREET, index=index, ego=ActorSpec(0.37 * index, 0.0))) for index in range(FRAMES)]
    fields = {
        name: np.concatenate([getattr(scan, name) for scan, _ in both])
        for name in ("echo_pulse_width", "flags", "echo", "layer", "unit")
    }
    return fields, np.isin(np.concatenate([truth.cause for _, truth in both]), AIR), widest


@pytest.mark.parametrize("name", ["echo_pulse_width", "flags", "echo", "layer", "unit"])
def test_no_value_of_a_field_belongs_to_one_cause(drive, name):
    """Surfaces have each value that points of the air have; pulse widths by 0.1 m, with the exception of 1 % in rain
    and of 2 % in snow and fog.

    The exception is echoes wider than 5.6 m, of droplets merged with surfaces that are themselves merged.
    """
    fields, air, widest = drive
    cells = np.round(fields[name] / (0.1 if name == "echo_pulse_width" else 1.0)).astype(int)
    exclusive = ~np.isin(cells[air], cells[~air])
    assert air.sum() > 500
    assert exclusive.sum() <= (widest * air.sum() if name == "echo_pulse_width" else 0)


def test_pulse_widths_of_the_air_are_many_and_none_prevails(drive):
    fields, air, _ = drive
    _, counts = np.unique(np.round(fields["echo_pulse_width"][air], 2), return_counts=True)
    assert len(counts) > 20
    assert counts.max() < 0.15 * air.sum()


def test_flag_for_clutter_errs_both_ways(drive):
    """Half of the droplets have it, and 2 % of the other points."""
    fields, air, _ = drive
    flagged = (fields["flags"] & PointFlag.CLUTTER) > 0
    assert 0.01 < np.mean(flagged[~air]) < 0.03
    assert 0.2 < np.mean(flagged[air]) < 0.6


def widths_of_air(frames):
    """Return power over the threshold [dB] and pulse width of droplets and false alarms, less the bias of the layer."""
    draws, need = Draws(2, BEAMS), healthy()
    found = []
    for frame in range(frames):
        for some in (
            drops(Rain(True, rate_mm_per_h=50.0), BEAMS, need, draws, frame),
            false_alarms(FalseAlarms(rate=0.01), BEAMS, need, draws, frame),
        ):
            width = measure_widths(some.beam, echo_places(some.range), some.width, BEAMS, NoiseConfig(), draws, frame)
            over_db = 10 * np.log10(some.power / need.threshold[some.beam])
            found.append([over_db, width - BEAMS.layer_pulse_bias[some.beam]])
    return np.concatenate(found, axis=1)


def widths_of_surfaces(frames):
    """Return the same of echoes of cars and walls, without clutter."""
    draws = Draws(3, BEAMS)
    beams, bodies, around, context = placed_scene(LUX_RIG, FOOTPRINT, world(*STREET), DARK)
    echoes = Raycaster(beams, FOOTPRINT).cast(bodies, around, context)
    over_db = 10 * np.log10(echoes.power / context.threshold[echoes.beam])
    bias = beams.layer_pulse_bias[echoes.beam]
    found = [
        measure_widths(echoes.beam, echo_places(echoes.range), echoes.width, beams, NoiseConfig(), draws, frame) - bias
        for frame in range(frames)
    ]
    return np.stack([np.tile(over_db, frames), np.concatenate(found)])


def best_stump(first, second):
    """Return the best balanced accuracy of a threshold on one field that separates two samples."""
    levels = np.unique(np.concatenate([first, second]))
    below = [np.searchsorted(np.sort(sample), levels, side="right") / len(sample) for sample in (first, second)]
    return 0.5 + 0.5 * np.abs(below[0] - below[1]).max()


@pytest.mark.parametrize("over_db", range(12))
def test_a_threshold_on_the_pulse_width_does_not_find_the_air_at_equal_power(over_db):
    (air_db, air), (surface_db, surface) = widths_of_air(100), widths_of_surfaces(5)
    air = air[(air_db >= over_db) & (air_db < over_db + 1)]
    surface = surface[(surface_db >= over_db) & (surface_db < over_db + 1)]
    assert min(len(air), len(surface)) > 50
    assert best_stump(air, surface) < 0.65


def test_stump_separates_what_is_apart():
    assert best_stump(np.array([1.0, 2.0]), np.array([3.0, 4.0])) == 1.0
    assert best_stump(np.array([1.0, 2.0]), np.array([1.0, 2.0])) == 0.5
