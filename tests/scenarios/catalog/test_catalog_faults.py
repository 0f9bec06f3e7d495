"""Fault scenarios: identical traffic, and the described effect of each fault, by ground truth."""

import tomllib
from dataclasses import replace

import numpy as np
import pytest
from support.scanned import ahead, load, played, row, scans
from support.sensor_scenes import beams_of

from luxloop.scenarios.files.shipped import CATALOG
from luxloop.sensor_model.noise.noise_config import KINDS, NoiseConfig
from luxloop.sensor_model.rig.beams import beam_table
from luxloop.sensor_model.rig.rig import load_rig
from luxloop.sensor_model.truth import Cause, Loss, Part
from luxloop.sim.world import Mode

REFERENCE = "fault-free"
FAULTS = {
    "unit-outage": "outage",
    "dirty-sectors": "dirt",
    "sunlit-sectors": "sun",
    "heavy-dropout": "dropout",
    "calibration-error": "calibration",
    "pitch": "attitude",
}
"""Kind of noise of each scenario."""
OWN = {"description", "reason", "suite", "noise", "expect"}
"""Keys that may differ between the files."""


def level(frame):
    """Return a frame without pitch and roll of the bodies, which would add to the effects of the faults."""
    ego, actors = frame.ego, frame.actors
    ego, actors = (replace(one, attitude=np.zeros_like(one.attitude)) for one in (ego, actors))
    return replace(frame, ego=ego, actors=actors)


@pytest.fixture(scope="module")
def scanned():
    """Return every sixth frame of each scenario with level bodies, scanned; the traffic is simulated once."""
    return {
        name: [*scans(name, when=lambda f: f.index % 6 == 0, change=level, traffic=REFERENCE)]
        for name in (REFERENCE, *FAULTS)
    }


@pytest.fixture(scope="module")
def beams():
    scenario = load(REFERENCE)
    return beam_table(load_rig(str(scenario.rig), scenario.folder))


def lost(instants, cause, beams):
    """Return the rows of the beam table lost to a cause, per frame."""
    start = np.searchsorted(beams.unit, np.arange(len(beams.units)))
    for instant in instants:
        mine = instant.truth.lost_cause == cause
        yield instant, start[instant.truth.lost_unit[mine]] + instant.truth.lost_beam[mine]


def test_the_family_is_complete():
    assert {path.stem for path in (CATALOG / "faults").glob("*.toml")} == {REFERENCE, *FAULTS}


@pytest.mark.parametrize("name", FAULTS)
def test_the_files_differ_only_in_the_fault(name):
    one, other = (
        tomllib.loads((CATALOG / "faults" / f"{each}.toml").read_text(encoding="utf-8")) for each in (name, REFERENCE)
    )
    assert {key: one[key] for key in one.keys() - OWN} == {key: other[key] for key in other.keys() - OWN}
    assert load(REFERENCE).noise == NoiseConfig()
    noise = load(name).noise
    assert {kind for kind in KINDS if getattr(noise, kind) != getattr(NoiseConfig(), kind)} == {FAULTS[name]}


def test_the_traffic_matches_the_description():
    _, frames = played(REFERENCE)
    speed = np.array([np.hypot(*frame.ego.velocity_world) for frame in frames])
    assert speed.max() > 13.0
    assert np.all(speed[-12:] < 0.1)
    gap = [ahead(frame, "stopping") for frame in (frames[0], frames[-1])]
    assert gap[0] > 25.0
    assert 5.0 < gap[1] < 12.0
    assert ahead(frames[0], "passing") < -10.0
    assert ahead(frames[-1], "passing") > 20.0
    oncoming = [name for name in frames[0].actors.name if name.startswith("oncoming")]
    assert len(oncoming) == 5
    assert all(ahead(frames[0], name) > 50.0 and ahead(frames[-1], name) < -20.0 for name in oncoming)
    parked = [row(frames[60], name) for name in frames[60].actors.name if name.startswith("kerb")]
    assert len(parked) >= 3
    assert np.all(frames[60].actors.mode[parked] == Mode.STATIONARY)


@pytest.mark.parametrize("name", FAULTS)
def test_the_fault_affects_graded_vehicles(name, scanned):
    """A fault beyond the graded range, or too weak to move a point, would have no effect on the metrics."""
    changed = [
        (np.abs(faulty.points - sound.points) > 0.1 * sound.points)[sound.graded]
        for faulty, sound in zip(scanned[name], scanned[REFERENCE], strict=True)
    ]
    assert np.concatenate(changed).mean() > 0.05


def test_the_front_left_unit_is_silent_for_four_seconds(scanned, beams):
    for instant in scanned["unit-outage"]:
        heard = np.bincount(instant.scan.unit, minlength=len(beams.units)) > 0
        silent = 3.0 <= instant.frame.time < 7.0
        assert np.all(heard[1:]), instant.frame.time
        assert heard[0] != silent, instant.frame.time
        assert silent == np.any(instant.truth.lost_cause == Loss.OUTAGE)


def test_without_the_front_left_unit_a_sector_is_not_covered(beams):
    heading_deg = np.rad2deg(np.arctan2(beams.direction_ego[:, 1], beams.direction_ego[:, 0]))
    gap = (heading_deg > 20.5) & (heading_deg < 34.5)
    assert set(beams.unit[gap]) == {0}


def test_dirt_loses_beams_of_its_sectors_and_a_splash_all_of_them(scanned, beams):
    sectors = load("dirty-sectors").noise.dirt.sectors
    names = [mount.name for mount in load_rig("srx_six_lux", CATALOG).mounts]
    azimuth_deg = np.rad2deg(beams.azimuth)
    dirty = [
        (beams.unit == names.index(s.unit)) & (azimuth_deg >= s.from_deg - 1e-6) & (azimuth_deg <= s.to_deg + 1e-6)
        for s in sectors
    ]
    taken = np.concatenate([beam for _, beam in lost(scanned["dirty-sectors"], Loss.DIRT, beams)])
    assert np.all(np.any(dirty, axis=0)[taken])
    (splash,) = [where for where, s in zip(dirty, sectors, strict=True) if s.transmission == 0.0]
    assert splash[beams_of(scanned[REFERENCE][0].scan, beams)].any()
    assert not splash[beams_of(scanned["dirty-sectors"][0].scan, beams)].any()


def test_the_sun_loses_beams_towards_it(scanned, beams):
    sun = load("sunlit-sectors").noise.sun
    count = 0
    for instant, beam in lost(scanned["sunlit-sectors"], Loss.SUN, beams):
        heading = np.arctan2(beams.direction_ego[beam, 1], beams.direction_ego[beam, 0])
        off_deg = np.rad2deg(heading + instant.frame.ego.pose_world[2]) - sun.azimuth_deg
        assert np.all(np.abs(off_deg) <= sun.half_width_deg + 1e-6)
        count += len(beam)
    assert count > 100


def test_thirty_percent_of_the_beams_are_lost_at_random(scanned, beams):
    met = gone = 0
    for instant, beam in lost(scanned["heavy-dropout"], Loss.RANDOM, beams):
        gone += len(beam)
        met += np.count_nonzero((instant.scan.echo == 0) & (instant.truth.cause != Cause.FALSE_ALARM))
    assert gone / (gone + met) == pytest.approx(0.3, abs=0.01)


def test_contours_are_doubled_where_units_are_misaligned(scanned):
    doubled = {
        name: np.mean(np.concatenate([i.truth.cause[i.point_row >= 0] for i in scanned[name]]) == Cause.DOUBLED)
        for name in (REFERENCE, "calibration-error")
    }
    assert 0.0 < doubled[REFERENCE] < 0.5 * doubled["calibration-error"]
    assert doubled["calibration-error"] > 0.2


def test_pitch_causes_road_echoes_ahead_and_window_echoes_behind(scanned):
    """Real panes return few echoes: far behind, the beams on windows are lost; nearer, the interior returns some."""
    road = {name: sum(np.sum(i.truth.part == Part.GROUND) for i in scanned[name]) for name in (REFERENCE, "pitch")}
    assert road["pitch"] > 500 > 10 * road[REFERENCE]
    glass = {name: np.mean(np.concatenate(_on_glass(scanned[name], "behind"))) for name in (REFERENCE, "pitch")}
    assert glass["pitch"] > 0.05 > 10.0 * glass[REFERENCE]
    (points, hits), (points_level, hits_level) = (_far_behind(scanned[name]) for name in ("pitch", REFERENCE))
    assert hits > 0.7 * hits_level  # the layers do not pass over the car
    assert points < 0.5 * points_level


def _on_glass(instants, name):
    """Return per frame whether each point on an actor is on a pane or behind it, in the interior."""
    parts = [i.truth.part[i.point_row == row(i.frame, name)] for i in instants]
    return [np.isin(part, (Part.GREENHOUSE, Part.INTERIOR)) for part in parts]


def _far_behind(instants):
    """Return the points and the rays on the car behind while it is more than 20 m away."""
    far = [(i, row(i.frame, "behind")) for i in instants if ahead(i.frame, "behind") < -20.0]
    return sum(i.points[car] for i, car in far), sum(i.truth.hits[car] for i, car in far)
