"""The ceiling of HOTA by hand, and beside the tracker on a short run."""

import json
from pathlib import Path

import numpy as np
import pytest
from support import busy_street, short_run
from support.frames import Body, grade_run, make_frames, observe

import luxloop
from luxloop.scenarios.cli import main
from luxloop.scenarios.errors import InputError
from luxloop.scenarios.grading.body_points import Ranging
from luxloop.scenarios.grading.grading_config import GradingConfig
from luxloop.scenarios.oracle import ceiling as ceiling_module
from luxloop.scenarios.oracle.ceiling_tracker import CeilingFactory, CeilingTracker, PoseNoise, assumed_ends
from luxloop.scenarios.run import device

FRAMES = 10
RANGING = Ranging(np.zeros((8, 3)), np.zeros(8))
EXACT = PoseNoise(0.0, 0.0)
USUAL = (4.70, 1.82, 1.46)
"""Usual size of a car."""


def tracker(noise=EXACT):
    return CeilingTracker(GradingConfig(), RANGING, noise, seed=1)


def ids(points):
    """Ids of the tracks in each frame, by the points on the car."""
    scene = [[Body(0, 20.0, 0.0, points=count)] for count in points]
    ideal, found = tracker(), []
    for frame, bodies in zip(make_frames(scene), scene, strict=True):
        scan, truth = observe(frame, bodies)
        device.show_truth(ideal, frame, truth)
        found.append(ideal.step(scan).id.tolist())
    return found


@pytest.mark.parametrize(("length", "fraction"), [(4.70, 1.0), (4.70 * 0.88, 17 / 19)], ids=["usual", "short"])
def test_hota_of_a_car_whose_rear_is_seen(length, fraction):
    """It is missed in the first of 10 frames: detection and association accuracy are 9 / 10.

    Points are at its rear. A length of 0.88 of the usual one overlaps by that, which 17 of 19 thresholds accept.
    """
    scene = [[Body(0, 20.0, 0.0, size=(length, *USUAL[1:]))]] * FRAMES
    metrics = grade_run(scene, tracker())[0]
    assert metrics["track.hota"].value == pytest.approx(0.9 * fraction)
    assert metrics["track.false_on_nothing"].value == 0.0


def test_errors_of_the_poses_are_the_stated_ones():
    scene = [[Body(i, 20.0, 5.0 * i - 20.0, size=USUAL) for i in range(9)]] * 100
    _, tables, _ = grade_run(scene, tracker(PoseNoise(2.0, 0.1)))
    judged = tables["tracks"].query("judged")
    assert len(judged) == 9 * 99
    assert judged["heading_error_deg"].std() == pytest.approx(2.0, rel=0.1)
    assert (judged["x_world_m"] - 20.0).std() == pytest.approx(0.1, rel=0.1)
    assert (judged["y_world_m"] - 5.0 * judged["actor_id"] + 20.0).std() == pytest.approx(0.1, rel=0.1)


def test_a_track_starts_at_the_second_frame_with_enough_points_and_survives_gaps():
    """The grader remembers a vehicle for 3 s, 37 frames of 80 ms; after a longer gap it is another one."""
    assert ids([9, 10, 9, 10, 0, 10]) == [[], [], [], [0], [], [0]]
    assert ids([10, 10, *[0] * 36, 10]) == [[], [0], *[[]] * 36, [0]]
    assert ids([10, 10, *[0] * 37, 10, 10]) == [[], [0], *[[]] * 37, [], [1]]


def test_ends_are_assumed_from_the_known_one_on():
    size, usual = np.array([[4.0, 1.8]] * 4), np.array([[5.0, 2.0]] * 4)
    low = np.array([[-2.0, -0.9], [0.5, -0.9], [-1.0, -0.5], [np.inf, np.inf]])
    high = np.array([[2.0, 0.0], [2.0, 0.9], [1.0, 0.3], [-np.inf, -np.inf]])
    found = np.hstack(assumed_ends(low, high, size, usual))
    np.testing.assert_allclose(
        found, [[-2.0, -0.9, 2.0, 1.1], [-3.0, -0.9, 2.0, 0.9], [-2.5, -1.1, 2.5, 0.9], [-2.5, -1.0, 2.5, 1.0]]
    )


def test_the_ceiling_of_a_run_is_above_its_tracker():
    """Both cars are graded in all ten frames and have the usual size: only their first frame is lost."""
    (found,) = luxloop.ceiling(busy_street.scenario(short_run.TEXT))
    assert found.hota == short_run.result().metrics["track.hota"].value
    assert found.exact == pytest.approx(0.9)
    assert found.hota < found.noisy < found.exact
    assert sum(found.losses.values()) == pytest.approx(1.0 - found.hota)


def test_the_command_prints_the_ceilings_of_all_seeds(tmp_path, monkeypatch, capfd):
    monkeypatch.chdir(tmp_path)
    short_run.write(Path())
    assert main(["ceiling", "short.toml", "--seeds", "3-4", "--duration", "0.4", "--heading-std", "0", "--json"]) == 0
    out, err = capfd.readouterr()
    found = json.loads(out)
    assert err == ""
    assert [run["seed"] for run in found["runs"]] == [3, 4]
    assert found["noise"] == {"heading_deg": 0.0, "position_m": 0.05}
    assert found["mean"]["exact"] == pytest.approx(np.mean([run["exact"] for run in found["runs"]]))
    assert main(["ceiling", "short.toml", "--seeds", "3-4", "--seed", "3"]) == 2


def test_an_ideal_tracker_is_marked_and_not_compared():
    scenario = busy_street.scenario(short_run.TEXT)
    made = CeilingFactory(scenario.grading, RANGING, PoseNoise(), 1)
    result = luxloop.run(scenario, tracker=made, duration_s=0.24, ahead=False)
    assert result.config["device"] == "oracle: ceiling, 1 deg, 0.05 m"
    with pytest.raises(InputError, match="ground truth"):
        luxloop.compare(result, result)


def test_a_missing_value_has_no_loss():
    empty = ceiling_module.Ceiling("a", 1, "", 1, "", None, 0.9, 0.8)
    assert empty.losses == pytest.approx({"scans": 0.1, "noise": 0.1, "tracker": None})
    assert ceiling_module.mean([empty], "hota") is None
