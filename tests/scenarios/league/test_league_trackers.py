"""Adapters of the league on boxes of hand-made drives."""

import tomllib
from dataclasses import asdict
from pathlib import Path

import numpy as np
import pytest
from support.optional import need

need("league")

from support.scripted_boxes import DT_S, ScriptedDetector, scans

from luxloop.scenarios.league.entrants import Entrant, entrants
from luxloop.scenarios.league.trackers.bicycle_filter import BicycleFilter
from luxloop.scenarios.league.trackers.paper_variant import paper_variant
from luxloop.scenarios.run.device import REFERENCE
from luxloop.tracker.records import Status
from luxloop.tracker.tracker import TrackerConfig

ROOT = Path(__file__).parents[3]
PEERS = [name for name in entrants() if name not in (REFERENCE, "paper")]
STD_M, SPEED_MPS, FRAMES, SETTLED = 0.1, 10.0, 60, 20


def follow(name, drive):
    """Return the tracks of a peer with its defaults for each frame of a drive."""
    peer = Entrant(name, entrants()[name].place, "")
    device = peer(TrackerConfig(), make_detector=lambda _config: ScriptedDetector(drive))
    return [device.step(scan) for scan in scans(len(drive))]


def straight(seed=0):
    """Return a car that passes from behind at a constant speed, with noise, and its true centres."""
    rng = np.random.default_rng(seed)
    truth = np.column_stack([-25.0 + SPEED_MPS * DT_S * np.arange(FRAMES), np.full(FRAMES, 4.0)])
    seen = truth + rng.normal(0.0, STD_M, truth.shape)
    return [(seen[k], [0.0]) for k in range(FRAMES)], truth


@pytest.mark.parametrize("name", PEERS)
def test_a_straight_drive_has_one_id_and_is_as_accurate_as_its_measurements(name):
    drive, truth = straight()
    tracks = follow(name, drive)[SETTLED:]
    assert [len(each) for each in tracks] == [1] * len(tracks)
    assert len({int(each.id[0]) for each in tracks}) == 1
    assert {int(each.status[0]) for each in tracks} == {Status.CONFIRMED}
    error = np.array([each.center_odom[0] for each in tracks]) - truth[SETTLED:]
    # The measurements have a root mean square error of STD_M per axis; over 40 frames and two axes it is known to
    # 1 / sqrt(2 * 80) = 8 %. A filter that follows must not be worse; 25 % are three times that.
    assert np.sqrt((error**2).mean()) < 1.25 * STD_M
    velocity = np.array([each.mean[0, 2:4] for each in tracks])
    # Two measurements over the time that a filter needs to settle, 1 s, give 0.14 m/s; five times that.
    assert np.abs(velocity.mean(axis=0) - [SPEED_MPS, 0.0]).max() < 5 * np.sqrt(2.0) * STD_M
    assert np.allclose([each.mean[0, 6] for each in tracks], 0.0, atol=0.2)
    assert np.allclose([each.size[0] for each in tracks], [4.5, 1.8], atol=1e-9)


@pytest.mark.parametrize("name", PEERS)
def test_equal_boxes_give_equal_tracks(name):
    drive, _ = straight(1)
    for one, other in zip(follow(name, drive), follow(name, drive), strict=True):
        assert np.array_equal(one.id, other.id)
        assert np.array_equal(one.mean, other.mean, equal_nan=True)


@pytest.mark.parametrize("name", PEERS)
def test_a_car_without_boxes_coasts_and_ends(name):
    drive, _ = straight()
    tracks = follow(name, [*drive[:30], *[((), ())] * 30])
    assert tracks[30].status.tolist() == [Status.COASTING]
    assert len(tracks[-1]) == 0  # coast_s is 1 s; 2.4 s are over


def between_two(name, y=5.0, off=0.6):
    """Return the y of the only confirmed track after a standing car is replaced by two boxes at y - off and y + off."""
    car, two = ([10.0, y], [0.0]), ([[10.0, y - off], [10.0, y + off]], [0.0, 0.0])
    last = follow(name, [*[car] * 15, two])[-1]
    return float(last.center_odom[last.status == Status.CONFIRMED][0, 1])


def test_jpda_averages_two_equally_likely_boxes_and_nearest_neighbour_takes_one():
    assert between_two("jpda") == pytest.approx(5.0, abs=1e-6)  # both have the same probability
    assert abs(between_two("nearest-neighbour") - 5.0) > 0.05


def test_multi_hypothesis_keeps_the_id_when_a_wrong_box_is_nearer_for_one_scan():
    # A car drives on; in one scan a box beside it is nearer to the prediction than the car's own.
    drive, truth = straight()
    drive[30] = ([truth[30] + [0.0, 0.35], truth[30] - [0.0, 0.3]], [0.0, 0.0])
    tracks = follow("multi-hypothesis", drive)
    confirmed = [each.id[each.status == Status.CONFIRMED] for each in tracks[SETTLED:]]
    assert {int(found[0]) for found in confirmed} == {0}
    assert np.abs(tracks[-1].center_odom[0] - truth[-1]).max() < 3.0 * STD_M


@pytest.mark.parametrize("name", PEERS)
def test_two_cars_keep_two_ids(name):
    drive = [([[-20.0 + 0.8 * k, 4.0], [20.0 - 0.8 * k, -4.0]], [0.0, 0.0]) for k in range(40)]
    tracks = follow(name, drive)[SETTLED:]
    order = [each.id[np.argsort(each.center_odom[:, 1])].tolist() for each in tracks]
    assert all(ids == order[0] and len(ids) == 2 for ids in order)


def test_the_prediction_of_the_bicycle_filter_has_the_numerical_jacobian():
    mean = np.array([3.0, -2.0, 0.7, 8.0, 0.1])
    rng = np.random.default_rng(0)
    root = rng.normal(size=(5, 5))
    covariance = root @ root.T

    def moved(state):
        each = BicycleFilter(state.copy(), covariance.copy())
        each.predict(0.08, 4.5, 0.0, 0.0)
        return each

    step = 1e-6
    columns = [(moved(mean + step * e).mean - moved(mean - step * e).mean) / (2 * step) for e in np.eye(5)]
    jacobian = np.column_stack(columns)
    assert np.allclose(moved(mean).covariance, jacobian @ covariance @ jacobian.T, rtol=1e-6, atol=1e-8)


def test_a_bicycle_with_constant_slip_drives_a_circle():
    # Radius l / sin(slip) = 1.35 / sin(0.1) = 13.52 m; half a turn at 5 m/s takes pi * 13.52 / 5 = 8.496 s.
    each = BicycleFilter(np.array([0.0, 0.0, -0.1, 5.0, 0.1]), np.eye(5))
    for _ in range(8496):
        each.predict(0.001, 4.5, 0.0, 0.0)
    assert each.mean[:2] == pytest.approx([0.0, 2 * 13.52], abs=0.03)


def test_the_paper_variant_has_the_settings_of_its_example():
    example = tomllib.loads((ROOT / "docs/examples/paper-variant.toml").read_text(encoding="utf-8"))["tracker"]
    wanted = {key: values for key, values in example.items() if key != "baselines"}
    made, shipped = asdict(paper_variant(TrackerConfig()).config), asdict(TrackerConfig())
    changed = {
        section: {key: value for key, value in values.items() if value != shipped[section][key]}
        for section, values in made.items()
        if values != shipped[section]
    }
    assert changed == wanted


def test_adapters_have_at_most_100_lines():
    folder = ROOT / "scenarios/league/trackers"
    modules = {each.place.partition(":")[0] for name, each in entrants().items() if name != REFERENCE}
    for module in modules:
        path = folder / f"{module.rpartition('.')[2]}.py"
        assert len(path.read_text(encoding="utf-8").splitlines()) <= 100, path
