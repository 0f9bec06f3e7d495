"""The complete tracker on scans of the synthetic rig."""

import copy
import pickle
from pathlib import Path

import numpy as np
import pytest
from support.few import few

from luxloop.sensor_model.lidar import Lidar
from luxloop.sensor_model.noise.noise_config import LayerOverlap, NoiseConfig
from luxloop.sensor_model.rig.rig import load_rig
from luxloop.sensor_model.sensor_config import SensorConfig
from luxloop.sim.scripted.motions import Straight
from luxloop.sim.scripted.script import ScriptedActor, ScriptedEgo, ScriptedObstacle
from luxloop.sim.scripted.scripted_source import ScriptedSource, ScriptedTraffic
from luxloop.tracker.detection.deskew import DeskewConfig
from luxloop.tracker.records import Status
from luxloop.tracker.tracker import Tracker, TrackerConfig

LONG_WALL = ScriptedObstacle(corners_m=[(-40.0, 8.0), (40.0, 8.0), (40.0, 12.0), (-40.0, 12.0)], height_m=6.0)


def drive(frames, ego_mps=0.0, actors=(), obstacles=(), flat_faces=False):
    """Yield (frame, scan) of scripted traffic; the ego drives along x."""
    noise = NoiseConfig(ideal=True, layer_overlap=LayerOverlap(enabled=not flat_faces))
    traffic = ScriptedTraffic(
        ego=ScriptedEgo(motion=[Straight(kind="straight", speed_mps=ego_mps)]),
        actor=list(actors),
        obstacle=list(obstacles),
        jitter_m=0.0,
        jitter_deg=0.0,
    )
    source = ScriptedSource(traffic, Path(), range_m=100.0)
    lidar = Lidar(load_rig("srx_six_lux", Path()), noise, SensorConfig(), seed=1, obstacles=source.reset(1))
    for _ in range(frames):
        frame = source.step()
        yield frame, lidar.scan(frame)[0]
    source.close()


def car(x_m, y_m, speed_mps=0.0, yaw_deg=0.0, **keys):
    motion = [Straight(kind="straight", speed_mps=speed_mps)]
    return ScriptedActor(x_m=x_m, y_m=y_m, yaw_deg=yaw_deg, motion=motion, reflectivity=0.5, **keys)


def confirmed(tracks):
    return np.flatnonzero(tracks.status == Status.CONFIRMED)


@pytest.mark.parametrize("lane_m", few([3.5, -3.5], 3.5))
def test_an_overtaking_car_keeps_its_id_and_position(lane_m):
    """It passes from far behind to far ahead, so that several corners are the nearest in turn."""
    tracker, ids = Tracker(), set()
    for frame, scan in drive(120, ego_mps=10.0, actors=[car(-30.0, lane_m, speed_mps=16.0)]):
        tracks, _ = tracker.step(scan)
        sure = confirmed(tracks)
        if frame.index < 10:
            continue
        assert len(sure) == 1
        ids.add(int(tracks.id[sure[0]]))
        truth = frame.actors.pose_world[0]
        assert np.abs(tracks.center_odom[sure[0]] - truth[:2]).max() < 0.6
        assert abs(tracks.mean[sure[0], 6] - truth[2]) < np.radians(6)
    assert len(ids) == 1
    assert tracks.mean[confirmed(tracks)[0], 2] == pytest.approx(16.0, abs=0.4)


def test_an_oncoming_car_has_the_heading_of_its_motion():
    tracker = Tracker()
    for _, scan in drive(30, ego_mps=10.0, actors=[car(55.0, 3.5, speed_mps=12.0, yaw_deg=180.0)]):
        tracks, _ = tracker.step(scan)
    sure = confirmed(tracks)
    assert len(sure) == 1
    assert abs(tracks.mean[sure[0], 6]) == pytest.approx(np.pi, abs=0.1)


@pytest.mark.parametrize(("motion", "agree"), [("all", True), ("none", True), ("ego", False)])
def test_two_units_agree_on_the_rear_of_a_car_that_keeps_its_distance(motion, agree):
    """At 25 m/s either uncompensated motion would separate their measurements by 0.3 m.

    The rear is flat: on a bowed one the fitted corner varies by 0.1 m with the points of a scan.
    """
    tracker, rear_x = Tracker(TrackerConfig(deskew=DeskewConfig(motion=motion))), []
    for frame, scan in drive(30, ego_mps=25.0, actors=[car(20.0, 0.0, speed_mps=25.0)], flat_faces=True):
        _, trace = tracker.step(scan)
        if frame.index >= 10:
            rear_x.append(trace.boxes.corner_ego[0, 0])
    assert (np.ptp(rear_x) < 0.06) == agree
    assert np.mean(rear_x) == pytest.approx(20.0 - 4.7 / 2, abs=0.1 if agree else 0.3)


def test_a_partly_occluded_wall_is_not_confirmed():
    """A truck between the ego and the wall occludes it, which leaves pieces of a vehicle's length."""
    truck = car(-50.0, 4.0, speed_mps=10.0, kind="truck", name="truck")
    tracker, followed = Tracker(), set()
    for frame, scan in drive(70, actors=[truck], obstacles=[LONG_WALL]):
        tracks, _ = tracker.step(scan)
        sure = confirmed(tracks)
        followed |= set(tracks.id[sure[~tracks.small[sure]]].tolist())
        if frame.index > 10:
            assert (tracks.center_odom[sure, 1] < 7.0).all()
    assert len(followed) <= 2


def test_the_corner_of_a_house_that_comes_into_view_is_not_confirmed():
    """The ego drives along a street of houses; at each gap more and more of the next corner comes into view."""
    houses = [
        ScriptedObstacle(corners_m=[(x, 9.0), (x + 14.0, 9.0), (x + 14.0, 30.0), (x, 30.0)], height_m=8.0)
        for x in (-20.0, 2.0, 24.0, 46.0)
    ]
    tracker, frames_with_any = Tracker(), 0
    for _, scan in drive(60, ego_mps=8.0, obstacles=houses):
        tracks, _ = tracker.step(scan)
        frames_with_any += len(confirmed(tracks)) > 0
    assert frames_with_any <= 6


def test_equal_scans_give_equal_tracks():
    scans = [scan for _, scan in drive(15, ego_mps=10.0, actors=[car(15.0, 0.0, 12.0), car(20.0, 3.5, 9.0)])]
    runs = []
    for _ in range(2):
        tracker = Tracker()
        runs.append([tracker.step(scan)[0] for scan in scans][-1])
    assert len(runs[0]) >= 2
    for field in ("id", "mean", "covariance", "model_probability", "size"):
        np.testing.assert_array_equal(getattr(runs[0], field), getattr(runs[1], field))


class NoAssociation:
    """An associator that assigns no box."""

    def associate(self, tracks, predictions, hypotheses, seen):
        assert len(predictions.heading) == len(tracks)
        assert hypotheses.heading.shape == (len(tracks), len(seen))
        return []


class NoManagement:
    """A track management that starts no tracks."""

    def manage(self, tracks, *_):
        return tracks


def test_stages_are_replaced_by_objects():
    """Without association no track is confirmed; without track management there is none."""
    scans = [scan for _, scan in drive(6, ego_mps=10.0, actors=[car(15.0, 0.0, 10.0)])]
    unassociated, unmanaged = Tracker(associator=NoAssociation()), Tracker(track_management=NoManagement())
    for scan in scans:
        tracks, trace = unassociated.step(scan)
        assert len(trace.boxes) == 1
        assert len(unmanaged.step(scan)[0]) == 0
    assert len(tracks) >= 1
    assert len(confirmed(tracks)) == 0


def test_a_copied_tracker_continues_like_the_original():
    scans = [scan for _, scan in drive(10, ego_mps=10.0, actors=[car(15.0, 0.0, 12.0)])]
    tracker = Tracker()
    for scan in scans[:5]:
        tracker.step(scan)
    copies = [copy.deepcopy(tracker), pickle.loads(pickle.dumps(tracker))]
    for scan in scans[5:]:
        expected = tracker.step(scan)[0]
        for other in copies:
            np.testing.assert_array_equal(other.step(scan)[0].mean, expected.mean)
