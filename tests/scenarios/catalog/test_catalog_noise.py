"""Noise scenarios: one scene with every aspect in five files, each with its own kinds of noise."""

import tomllib
from dataclasses import asdict

import numpy as np
import pytest

from luxloop.scenarios.files.scenario import Scenario
from luxloop.scenarios.files.shipped import CATALOG
from luxloop.scenarios.grading.frame_truth import FrameTruth
from luxloop.sensor_model.lidar import Lidar
from luxloop.sensor_model.noise.noise_config import KINDS, NoiseConfig
from luxloop.sensor_model.rig.rig import load_rig
from luxloop.sensor_model.truth import Cause, Loss, View
from luxloop.sim.scripted.scripted_source import ScriptedSource
from luxloop.sim.world import Kind, Mode

AIRS = {"fog", "snow"}
"""Kinds that are off in all files: they take sight and points from every other kind."""
SWITCHED = set(KINDS) - AIRS
ON = {
    "noise-none": set(),
    "noise-dropout": {"dropout"},
    "noise-mirror": {"mirror"},
    "noise-layer-overlap": {"layer_overlap"},
    "noise-all": SWITCHED,
}
OWN = {"description", "reason", "suite", "noise", "expect"}
"""Keys that may differ between the files."""
EVERY = 6
"""Stride: one of this number of frames is scanned."""


def path(name):
    return CATALOG / "noise" / f"{name}.toml"


def scans(name):
    """Yield every sixth frame with its scan and ground truth."""
    scenario = Scenario.load(path(name))
    rig = load_rig(str(scenario.rig), scenario.folder)
    source = ScriptedSource(scenario.traffic, scenario.folder, range_m=200.0)
    lidar = Lidar(rig, scenario.noise, scenario.sensor, scenario.seed, source.reset(scenario.seed))
    for index in range(round(scenario.duration_s / source.dt)):
        frame = source.step()
        if index % EVERY == 0:
            yield frame, *lidar.scan(frame)


@pytest.fixture(scope="module")
def played():
    return {name: list(scans(name)) for name in ON}


def causes(played, name):
    return np.concatenate([truth.cause for _, _, truth in played[name]])


def off_the_sides_m(played):
    """Return distances [m] of points on parked vehicles from the nearest side of their box."""
    distances = []
    for frame, scan, truth in played:
        at = frame.ego.pose_world[:2] + scan.time_offset[:, None] * frame.ego.velocity_world + scan.points_ego[:, :2]
        actors = frame.actors
        for row in np.flatnonzero(np.char.startswith(actors.name, "parked")):
            inside = actors.size[row, :2] / 2 - np.abs(
                (at - actors.pose_world[row, :2])[truth.actor_id == actors.id[row]]
            )
            distances.append(np.abs(inside.min(axis=1)))
    return np.concatenate(distances)


def test_the_family_is_complete():
    assert {file.stem for file in (CATALOG / "noise").glob("*.toml")} == set(ON)


def test_the_files_differ_only_in_noise():
    documents = [tomllib.loads(path(name).read_text(encoding="utf-8")) for name in ON]
    shared = [{key: value for key, value in document.items() if key not in OWN} for document in documents]
    assert all(other == shared[0] for other in shared[1:])


@pytest.mark.parametrize(("name", "on"), ON.items())
def test_each_file_sets_every_kind_of_noise_with_its_default_strength(name, on):
    """A new kind of noise that is on by default must not be active in `noise-none`."""
    switches = tomllib.loads(path(name).read_text(encoding="utf-8"))["noise"]
    assert switches == {kind: {"enabled": kind in on} for kind in SWITCHED}
    default = asdict(NoiseConfig())
    settings = asdict(Scenario.load(path(name)).noise)
    for kind in KINDS:
        assert settings[kind] == default[kind] | {"enabled": kind in on}


@pytest.mark.parametrize("name", ON)
def test_every_expectation_has_a_unit_and_a_need(name):
    limits = Scenario.load(path(name)).expect
    assert [metric for metric, limit in limits.items() if not (limit.unit and limit.need)] == []


def test_the_scene_shows_cars_vans_and_trucks_from_all_sides(played):
    grading = Scenario.load(path("noise-none")).grading
    views, kinds, modes, octants = set(), set(), set(), set()
    for frame, scan, truth in played["noise-none"]:
        graded = FrameTruth.of(frame, scan, truth, grading).graded
        offset = frame.actors.pose_world[:, :2] - frame.ego.pose_world[:2]
        aspect = frame.actors.pose_world[:, 2] - np.arctan2(offset[:, 1], offset[:, 0])
        views |= set(truth.view[graded])
        kinds |= set(frame.actors.kind[graded])
        modes |= set(frame.actors.mode[graded])
        octants |= set(np.floor(aspect[graded] % (2 * np.pi) / (np.pi / 4)).astype(int))
    assert views >= {View.L_SHAPE, View.SIDE, View.REAR, View.FRONT}
    assert kinds >= {Kind.CAR, Kind.SUV, Kind.VAN, Kind.TRUCK}
    assert modes == set(Mode)
    assert octants == set(range(8))


def test_without_noise_every_point_on_a_parked_car_is_on_a_side_of_its_box(played):
    """Detects mirrors, layer overlap, range errors and errors of the ego pose."""
    assert set(causes(played, "noise-none")) == {Cause.CLEAN}
    assert off_the_sides_m(played["noise-none"]).max() < 0.02
    assert np.median(off_the_sides_m(played["noise-all"])) > 0.02


@pytest.mark.parametrize(
    ("name", "cause"), [("noise-mirror", Cause.MIRROR), ("noise-layer-overlap", Cause.LAYER_OVERLAP)]
)
def test_a_single_kind_makes_only_its_own_outliers(played, name, cause):
    assert set(causes(played, name)) == {Cause.CLEAN, cause}


def test_dropout_loses_one_beam_in_a_hundred_at_random(played):
    assert set(causes(played, "noise-dropout")) == {Cause.CLEAN}
    losses = {name: np.concatenate([truth.lost_cause for *_, truth in played[name]]) for name in ON}
    assert set(losses["noise-none"]) == {Loss.THRESHOLD}
    assert set(losses["noise-dropout"]) == {Loss.THRESHOLD, Loss.RANDOM}
    at_random = np.count_nonzero(losses["noise-dropout"] == Loss.RANDOM)
    returned = sum(len(scan) for _, scan, _ in played["noise-dropout"])
    assert at_random / (at_random + returned) == pytest.approx(0.01, abs=0.003)


def test_all_kinds_of_noise_occur_in_combination(played):
    assert set(causes(played, "noise-all")) >= {
        Cause.CLEAN,
        Cause.MIRROR,
        Cause.LAYER_OVERLAP,
        Cause.RANGE_OUTLIER,
        Cause.RAIN,
    }
