"""Emergence of actors in hand-made scenes: times, distances, censoring, and which track is on which actor."""

import math

import numpy as np
import pytest
import scipy
from support.frames import DT, Body, Estimate, Scripted, drive, follow, grade_run

from luxloop.scenarios.grading.emergence import survival
from luxloop.scenarios.grading.grading_config import GradingConfig
from luxloop.sim.world import Kind
from luxloop.tracker.records import Status

NAMED = GradingConfig(target="car1")
ON = {"points": 20}


def scene(points, kind=Kind.CAR, **more):
    """Return a scene of one actor that stands at (12, 4), with some points in each frame."""
    return [[Body(1, 12.0, 4.0, points=n, kind=kind, **more)] for n in points]


def grade(bodies, script, config=NAMED, **more):
    metrics, tables, _ = grade_run(bodies, Scripted(script), config=config, **more)
    values = {name.removeprefix("emergence."): metric for name, metric in metrics.items() if "emergence" in name}
    return values, tables["emergence"].set_index("stage")


def tracks(bodies, *changes):
    """Return one track on the first body of each frame; None for a frame without a track."""
    return [
        [] if change is None else [follow(frame[0], **change)] for frame, change in zip(bodies, changes, strict=True)
    ]


def test_stages_are_reached_in_their_first_frames():
    bodies = scene([0, 3, 9, 10, 20, 20, 20])
    tentative = {"status": Status.TENTATIVE}
    script = tracks(bodies, None, None, tentative, tentative, {"x": 12.6}, {"heading": 0.1}, {"x": 12.4})
    values, table = grade(bodies, script)
    frames = {"first_beam": 1, "enough_points": 3, "tentative": 2, "confirmed": 4, "located": 6}
    assert table["frame"].to_dict() == frames
    assert table["reached"].all()
    for stage, frame in frames.items():
        assert values[f"time_s{{stage={stage}}}"].value == pytest.approx(frame * DT)
        assert values[f"delay_s{{stage={stage}}}"].value == pytest.approx((frame - 1) * DT)
        assert values[f"range_m{{stage={stage}}}"].value == pytest.approx(math.hypot(12.0, 4.0))
        assert values[f"reached{{stage={stage}}}"].value == 1.0
    assert values["time_s{stage=end}"].reason == "all stages are reached"


def test_a_stage_that_is_never_reached_is_censored_at_the_end():
    bodies = scene([0, 5, 20, 20])
    values, table = grade(
        bodies, tracks(bodies, None, None, {"status": Status.TENTATIVE}, {"status": Status.TENTATIVE})
    )
    assert not table.loc["confirmed", "reached"]
    assert table.loc["confirmed", "time_s"] == pytest.approx(3 * DT)
    assert table.loc["confirmed", "delay_s"] == pytest.approx(2 * DT)
    never = values["time_s{stage=confirmed}"]
    assert (never.value, never.reason) == (None, "never reached")
    assert values["reached{stage=confirmed}"].value == 0.0
    assert values["time_s{stage=end}"].value == pytest.approx(3 * DT)
    assert values["delay_s{stage=end}"].value == pytest.approx(2 * DT)
    assert values["reached{stage=confirmed,group=vehicle}"].value == 0.0
    assert values["delay_s{stage=confirmed,group=vehicle}"].value is None


def test_an_actor_without_any_beam_has_no_delay_and_does_not_count_in_its_class():
    bodies = scene([0, 0, 0])
    values, table = grade(bodies, [[]] * 3)
    assert table["delay_s"].isna().all()
    assert values["delay_s{stage=end}"].reason == "no beam ever ended on it"
    assert values["reached{stage=first_beam,group=vehicle}"].reason == "no beam ended on a vehicle"


def test_a_track_is_on_the_actor_of_the_largest_overlap():
    near = [[Body(1, 12.0, 4.0, **ON), Body(2, 16.0, 4.0, **ON)]] * 2
    wide = Estimate(7, 15.0, 4.0, size=(4.6, 1.8), status=Status.TENTATIVE)
    _, table = grade(near, [[wide]] * 2)
    assert table[table["reached"] & (table.index == "tentative")]["actor_id"].tolist() == [2]


def test_a_coasting_track_and_one_before_the_first_beam_do_not_count():
    bodies = scene([0, 20, 20])
    values, _ = grade(bodies, tracks(bodies, {}, {"status": Status.COASTING}, {}))
    assert values["time_s{stage=confirmed}"].value == pytest.approx(2 * DT)
    assert values["time_s{stage=tentative}"].value == pytest.approx(2 * DT)


def test_a_person_is_in_a_box_of_any_size_and_has_no_heading():
    bodies = scene([20, 20], kind=Kind.PEDESTRIAN, size=(0.3, 0.5, 1.7))
    large = {"size": (4.6, 1.8), "x": 12.4, "heading": 1.0}
    values, _ = grade(bodies, tracks(bodies, large, large))
    assert values["reached{stage=located}"].value == 1.0
    assert values["delay_s{stage=located,group=person}"].value == 0.0
    assert values["reached{stage=located,group=vehicle}"].n == 0
    bodies = scene([20, 20], kind=Kind.BICYCLE, size=(1.6, 0.6, 1.7))
    values, _ = grade(bodies, tracks(bodies, large, large))
    reached = [values[f"reached{{stage={stage},group=bicycle}}"].value for stage in ("confirmed", "located")]
    assert reached == [1.0, 0.0]


def test_the_median_of_a_class_counts_those_that_never_reach_a_stage():
    # Seen from the first frame on; confirmed in frames 1 and 3 and never.
    frames = [[Body(i, 12.0, 8.0 * i, **ON) for i in range(3)] for _ in range(6)]
    script = [[follow(body) for body in row if index >= (1, 3, 99)[body.id]] for index, row in enumerate(frames)]
    values, _ = grade(frames, script, GradingConfig())
    assert values["delay_s{stage=confirmed,group=vehicle}"].value == pytest.approx(3 * DT)
    assert values["reached{stage=confirmed,group=vehicle}"].value == pytest.approx(2 / 3)
    # The ranges at confirmation are 12, 14.4 and never: the middle one of the order never, 12, 14.4.
    assert values["range_m{stage=confirmed,group=vehicle}"].value == pytest.approx(12.0)
    assert values["time_s{stage=confirmed}"].reason == "the scenario names no grading.target"


def test_distance_and_time_to_the_meeting_point_and_to_the_collision():
    # The ego (4.8 m by 1.9 m in these scenes) drives along x with 10 m/s from 0; a car crosses along x = 20.
    size = ego_size()
    bodies = [[Body(1, *drive(20.0, -16.0, math.pi / 2, 8.0, i), math.pi / 2, 8.0, **ON)] for i in range(40)]
    ego = lambda index: ((10.0 * index * DT, 0.0, 0.0),) * 2  # noqa: E731
    values, _ = grade(bodies, [[]] * 40, ego=ego)
    meeting_m = 20.0 - 0.5 * (size[1] + 1.8) - 0.5 * size[0]
    assert values["meeting_m{stage=first_beam}"].value == pytest.approx(meeting_m)
    assert values["meeting_s{stage=first_beam}"].value == pytest.approx(meeting_m / 10.0)
    # At the end of the run, the front is 31.2 m from its start and thus beyond the meeting point.
    assert values["meeting_m{stage=end}"].value == pytest.approx(meeting_m - 31.2)
    standing = scene([20])
    assert grade(standing, [[]])[0]["ttc_s{stage=first_beam}"].reason == "no collision course at constant velocities"


def ego_size():
    from support.frames import world_frame

    return world_frame(0, []).ego.size


def test_an_unknown_target_is_named():
    values, _ = grade(scene([20]), [[]], GradingConfig(target="lorry"))
    assert values["time_s{stage=confirmed}"].reason == 'no actor is named "lorry"'


@pytest.mark.parametrize("seed", range(20))
def test_survival_is_the_product_limit_estimate_of_scipy(seed):
    rng = np.random.default_rng(seed)
    times, reached = rng.integers(0, 8, 25).astype(np.float64), rng.random(25) < 0.6
    curve = scipy.stats.ecdf(scipy.stats.CensoredData.right_censored(times, ~reached)).sf
    at, share = survival(times, reached)
    assert at.tolist() == curve.quantiles.tolist()
    assert share == pytest.approx(curve.probabilities, abs=1e-12)
