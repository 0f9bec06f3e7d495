"""Echoes against values computed by hand: one beam of few rays, and walls that each block some of them.

Powers are in 1/m^2: a wall of reflectivity rho, hit by a share of a beam's rays at normal incidence at
range R adds share x rho / R^2 to the power, for the length of the pulse. The threshold is 0.1 / 50^2 = 4e-5.
"""

import math

import numpy as np
import pytest
from support.sensor_scenes import EXACT, NO_OBSTACLES, ahead, one_unit_rig, placed_scene, scan, small_unit, world

from luxloop.sensor_model.bodies.materials import Glass
from luxloop.sensor_model.raycaster import Raycaster
from luxloop.sensor_model.returns import WALL
from luxloop.sensor_model.rig.unit import Fan
from luxloop.sensor_model.sensor_config import SensorConfig
from luxloop.sensor_model.truth import Part
from luxloop.sim.world import Obstacles
from luxloop.tracker.scan import PointFlag

PULSE, GROWTH, THRESHOLD = 0.675, 0.03, 4e-5
WIDTH_DEG = 0.08
STRAIGHT = (Fan((0,), 0.0, 0.0, 1.0, (100.0,)),)
SPREAD = 1e-5  # [m] largest range difference over a beam 0.08 degrees wide


def unit(**changes):
    return small_unit(STRAIGHT, elevation_deg=(0.0,), **changes)


def stairs(*steps):
    """Return walls (range, reflectivity) across a beam along x; each blocks one column of rays, from the left."""
    edges_deg = WIDTH_DEG * (0.5 - np.arange(1, len(steps)) / len(steps))
    ends = [*(reach * math.tan(math.radians(edge)) for (reach, _), edge in zip(steps, edges_deg, strict=False)), -5.0]
    polygons = [np.array([[reach, 5.0], [reach, end]]) for (reach, _), end in zip(steps, ends, strict=True)]
    return Obstacles.from_polygons(polygons, [3.0] * len(steps), [reflectivity for _, reflectivity in steps])


def cast(obstacles, columns=1, extinction=0.0, **changes):
    """Return the echoes of one beam with one row of rays."""
    rig, sensor = one_unit_rig(unit(**changes), z=1.0), SensorConfig(footprint=(1, columns))
    beams, *scene = placed_scene(rig, sensor, world(), obstacles, extinction=extinction)
    return Raycaster(beams, sensor).cast(*scene)


def decibels(power):
    return 10.0 * math.log10(power / THRESHOLD)


def test_a_beam_across_the_foot_of_the_first_wall_is_on_the_wall():
    """Ground and first wall have the same surface number; the wall returns more."""
    obstacles = Obstacles.from_polygons([np.array([[10.0, 5.0], [10.0, -5.0]])], [3.0], 0.4)
    down = small_unit(STRAIGHT, elevation_deg=(-math.degrees(math.atan(0.1)),), beam_height_deg=WIDTH_DEG)
    sensor = SensorConfig(footprint=(2, 1))
    beams, *scene = placed_scene(one_unit_rig(down, z=1.0), sensor, world(), obstacles)
    assert Raycaster(beams, sensor).cast(*scene).target.tolist() == [WALL]


def test_one_wall():
    """0.4 / 20^2 = 1e-3 is 25 times the threshold: 13.98 dB, at 3 cm each."""
    echoes = cast(stairs((20.0, 0.4)))
    assert echoes.range == pytest.approx([20.0], abs=1e-12)
    assert echoes.power == pytest.approx([1e-3], rel=1e-12)
    assert echoes.width == pytest.approx([0.675 + 0.03 * 13.979400], abs=1e-7)
    assert (echoes.target[0], echoes.surface[0]) == (WALL, 0)
    assert len(echoes.lost_beam) == 0


def test_wall_below_the_threshold_loses_the_beam_and_reports_its_power():
    """0.1 / 60^2 = 2.78e-5, below the threshold; at 50 m it is just as strong."""
    echoes = cast(stairs((60.0, 0.1)))
    assert len(echoes.beam) == 0
    assert echoes.lost_beam.tolist() == [0]
    assert echoes.lost_power == pytest.approx([0.1 / 3600.0], rel=1e-12)
    assert len(cast(stairs((49.99, 0.1))).beam) == 1
    assert len(cast(stairs((50.01, 0.1))).beam) == 0


def test_beam_into_the_sky_has_no_echo_and_is_not_lost():
    echoes = cast(NO_OBSTACLES)
    assert len(echoes.beam) == len(echoes.lost_beam) == 0


@pytest.mark.parametrize(
    ("apart", "ranges", "widths_without_growth", "peak"),
    [
        # Closer than the pulse length: both are summed, 0.4 / 2 (1 / 10^2 + 1 / 10.5^2).
        (0.5, [10.0], [0.5 + PULSE], 2e-3 + 0.2 / 10.5**2),
        # Two pulses, closer than the echo separation of 1.4 m: one echo from the first to the end of the second.
        (1.0, [10.0], [1.0 + PULSE], 2e-3),
        (3.0, [10.0, 13.0], [PULSE, PULSE], 2e-3),
    ],
)
def test_two_walls_half_covered_each(apart, ranges, widths_without_growth, peak):
    echoes = cast(stairs((10.0, 0.4), (10.0 + apart, 0.4)), columns=2)
    assert echoes.range == pytest.approx(ranges, abs=SPREAD)
    assert echoes.power[0] == pytest.approx(peak, rel=1e-6)
    growth = [GROWTH * decibels(power) for power in echoes.power]
    assert echoes.width == pytest.approx(np.add(widths_without_growth, growth), abs=SPREAD)
    assert echoes.surface.tolist() == list(range(len(ranges)))


@pytest.mark.parametrize(("walls", "most", "ranges"), [(3, 3, 3), (4, 3, 3), (4, 1, 1), (4, 4, 4)])
def test_only_the_nearest_echoes_are_reported(walls, most, ranges):
    steps = [(10.0 + 3.0 * number, 0.4) for number in range(walls)]
    echoes = cast(stairs(*steps), columns=walls, echoes_max=most)
    assert echoes.range == pytest.approx([reach for reach, _ in steps][:ranges], abs=SPREAD)
    assert echoes.beam.tolist() == [0] * ranges


def test_separation_counts_from_the_start_of_an_echo():
    """At 10, 11 and 12 m with a separation of 1.4 m: the third is 2 m behind the start of the merged first two."""
    echoes = cast(stairs((10.0, 0.4), (11.0, 0.4), (12.0, 0.4)), columns=3)
    assert echoes.range == pytest.approx([10.0, 12.0], abs=SPREAD)


def test_weak_near_edge_does_not_trigger():
    """0.004 / (2 x 10^2) = 2e-5 is below the threshold; the second wall, 0.5 m behind, gives the range."""
    echoes = cast(stairs((10.0, 0.004), (10.5, 0.4)), columns=2)
    back = 0.4 / (2.0 * 10.5**2)
    assert echoes.range == pytest.approx([10.5], abs=SPREAD)
    assert echoes.surface.tolist() == [1]
    assert echoes.power == pytest.approx([2e-5 + back], rel=1e-6)
    assert echoes.width == pytest.approx([PULSE + GROWTH * decibels(2e-5 + back)], abs=SPREAD)


def test_two_weak_walls_within_a_pulse_trigger_together():
    """2.5e-5 + 2.36e-5 from 10.3 m to the end of the first pulse at 10.675 m; the point is on the second wall."""
    echoes = cast(stairs((10.0, 0.005), (10.3, 0.005)), columns=2)
    both = 0.005 / 200.0 + 0.005 / (2.0 * 10.3**2)
    assert echoes.range == pytest.approx([10.3], abs=SPREAD)
    assert echoes.width == pytest.approx([0.375 + GROWTH * decibels(both)], abs=2 * SPREAD)
    assert echoes.surface.tolist() == [1]
    assert len(cast(stairs((10.0, 0.005), (10.7, 0.005)), columns=2).beam) == 0


def test_point_is_at_the_start_of_the_echo_on_the_strongest_surface_there():
    """A strong wall within a pulse behind a weak but sufficient one: range and target are those of the near one.

    Fails if points on a mirror are assigned to the stronger door behind it. Within 10 cm, the order of the range noise,
    the stronger wall is the target.
    """
    echoes = cast(stairs((10.0, 0.02), (10.4, 0.4)), columns=2)
    assert echoes.range == pytest.approx([10.0], abs=SPREAD)
    assert echoes.surface.tolist() == [0]
    echoes = cast(stairs((10.0, 0.02), (10.05, 0.4)), columns=2)
    assert echoes.range == pytest.approx([10.0], abs=SPREAD)
    assert echoes.surface.tolist() == [1]


def test_slanted_wall_is_measured_at_its_near_edge_and_widens_the_pulse():
    """At 45 degrees to a beam 4 degrees wide, 10 m ahead: rays at +-0.5 and +-1.5 degrees hit it from 9.74 m on."""
    slanted = Obstacles.from_polygons([np.array([[15.0, -5.0], [5.0, 5.0]])], [3.0], 0.4)
    echoes = cast(slanted, columns=4, beam_width_deg=4.0)
    turns = np.deg2rad([1.5, 0.5, -0.5, -1.5])
    ranges = 10.0 / (np.cos(turns) + np.sin(turns))  # x + y = 10 along the ray
    power = np.sum(0.4 * np.cos(np.pi / 4 - turns) / (4.0 * ranges**2))
    assert echoes.range == pytest.approx([ranges[0]], abs=1e-12)
    assert echoes.power == pytest.approx([power], rel=1e-12)
    assert echoes.width == pytest.approx([np.ptp(ranges) + PULSE + GROWTH * decibels(power)], abs=1e-9)


def test_grazing_incidence_reduces_power():
    """A wall at a grazing angle of 10 degrees returns sin(10 degrees) of the power at normal incidence."""
    along = np.array([math.cos(math.radians(10.0)), math.sin(math.radians(10.0))])
    grazing = Obstacles.from_polygons([np.array([20.0, 0.0]) + np.outer([-10.0, 10.0], along)], [3.0], 0.4)
    assert cast(grazing).power == pytest.approx([0.4 * math.sin(math.radians(10.0)) / 400.0], rel=1e-12)


def test_air_attenuates_both_ways():
    assert cast(stairs((20.0, 0.4)), extinction=0.01).power == pytest.approx([1e-3 * math.exp(-0.4)], rel=1e-12)


def test_gain_scales_power():
    fans = (Fan((0,), 0.0, 0.0, 1.0, (35.0,)),)
    rig, sensor = one_unit_rig(small_unit(fans, (0.0,)), z=1.0), SensorConfig(footprint=(1, 1))
    beams, *scene = placed_scene(rig, sensor, world(), stairs((20.0, 0.4)))
    assert Raycaster(beams, sensor).cast(*scene).power == pytest.approx([0.35e-3], rel=1e-12)


def test_surface_below_the_minimum_range_blocks_only_its_rays():
    near_half = stairs((0.2, 0.4), (20.0, 0.4))
    assert len(cast(stairs((0.2, 0.4))).beam) == 0
    echoes = cast(stairs((0.2, 0.4)))
    assert echoes.lost_power.tolist() == echoes.lost_range.tolist() == [0.0]
    echoes = cast(near_half, columns=2)
    assert echoes.range == pytest.approx([20.0], abs=SPREAD)
    assert echoes.power == pytest.approx([0.5e-3], rel=1e-6)


def test_rays_over_and_under_a_guard_rail_hit_the_facade_behind():
    """A beam 6 degrees high, 10 m in front of a rail from 0.45 to 0.75 m: of four rays from a unit at 0.6 m, those at
    +-0.75 degrees hit it and those at +-2.25 degrees pass over and under it, to the facade."""
    polygons = [np.array([[reach, -5.0], [reach, 5.0]]) for reach in (10.0, 14.0)]
    obstacles = Obstacles.from_polygons(polygons, [0.75, 9.0], 0.4, base=[0.45, 0.0])
    rig, sensor = one_unit_rig(unit(beam_height_deg=6.0), z=0.6), SensorConfig(footprint=(4, 1))
    beams, *scene = placed_scene(rig, sensor, world(), obstacles)
    echoes = Raycaster(beams, sensor).cast(*scene)
    rail, facade = np.cos(np.deg2rad([0.75, 2.25]))
    assert echoes.surface.tolist() == [0, 1]
    assert echoes.range == pytest.approx([10.0 / rail, 14.0 / facade], abs=1e-12)
    assert echoes.power == pytest.approx([0.2 * rail**3 / 100.0, 0.2 * facade**3 / 196.0], rel=1e-12)


PANE_REFLECTIVITY, TRANSMISSION, INTERIOR = 0.06, 0.8, 0.2


def through_a_window(**glass):
    """Return the scene of one level ray at 1.2 m into the rear window of a car 10 m ahead; echo separation 0.3 m."""
    glass = Glass(pane_reflectivity=PANE_REFLECTIVITY, interior_reflectivity=INTERIOR, **glass)
    rig = one_unit_rig(unit(pulse_length_m=0.1, echo_separation_m=0.3), z=1.25)
    return scan(ahead(10.0), rig=rig, sensor=SensorConfig(footprint=(1, 1), glass=glass))


def test_pane_and_interior_give_two_echoes():
    """The first echo is flagged transparent, because the beam has another one behind it."""
    result, truth = through_a_window(transmission=TRANSMISSION)
    assert truth.part.tolist() == [Part.GREENHOUSE, Part.INTERIOR]
    assert result.echo.tolist() == [0, 1]
    assert result.flags.tolist() == [PointFlag.TRANSPARENT, 0]
    assert np.all(truth.actor_id == 0)
    assert 0.3 < truth.true_range[1] - truth.true_range[0] < 3.0


def test_opaque_pane_hides_the_interior():
    result, truth = through_a_window(transmission=0.0)
    assert truth.part.tolist() == [Part.GREENHOUSE]
    assert result.flags.tolist() == [0]


def test_interior_is_attenuated_by_two_passages_of_the_pane():
    """Fails if transmission is applied once, or if the pane's cosine or range is used for the interior."""
    rig = one_unit_rig(unit(pulse_length_m=0.1, echo_separation_m=0.0), z=1.25)
    powers = {}
    for transmission in (0.8, 0.4):
        sensor = SensorConfig(footprint=(1, 1), glass=Glass(0.06, transmission, interior_reflectivity=0.2))
        beams, bodies, walls, context = placed_scene(rig, sensor, world(ahead(10.0)))
        echoes = Raycaster(beams, sensor).cast(bodies, walls, context)
        powers[transmission] = echoes.power
        nx = bodies.planes[echoes.surface[1], 0]
        assert bodies.plane_part[echoes.surface].tolist() == [Part.GREENHOUSE, Part.INTERIOR]
        expected = transmission**2 * bodies.plane_reflectivity[echoes.surface[1]] * -nx / echoes.range[1] ** 2
        assert echoes.power[1] == pytest.approx(expected, rel=1e-12)
    assert powers[0.8][1] == pytest.approx(4.0 * powers[0.4][1], rel=1e-12)
    assert powers[0.8][0] == powers[0.4][0]


def test_beam_on_two_objects_is_flagged_transparent():
    """Every echo but the last is flagged: the unit cannot distinguish a pane from an edge."""
    rig = one_unit_rig(unit(), z=1.0)
    obstacles = stairs((10.0, 0.4), (13.0, 0.4), (16.0, 0.4))
    result, _ = scan(rig=rig, obstacles=obstacles, sensor=SensorConfig(footprint=(1, 3)), noise=EXACT)
    assert result.echo.tolist() == [0, 1, 2]
    assert (result.flags & PointFlag.TRANSPARENT).astype(bool).tolist() == [True, True, False]
