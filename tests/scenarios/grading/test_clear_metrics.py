"""Time to confirm, shares of missed vehicles, and false tracks by kind, by hand."""

import pytest
from support.frames import DT, Body, Estimate, Scripted, follow, grade_run

from luxloop.sim.world import Kind
from luxloop.tracker.records import Status

FRAMES = 10
CAR = Body(0, 10.0, 5.0)


def metrics_of(scene, script, **options):
    return grade_run(scene, Scripted(script), **options)[0]


def values(metrics, *names):
    return [metrics[f"track.{name}"].value for name in names]


# --- time to confirm


def confirmed_after(*frames):
    """Metrics of cars side by side, each confirmed after a number of frames, or never (None)."""
    cars = [Body(i, 4.0 * i, 8.0, yaw=1.57) for i in range(len(frames))]
    status = {True: Status.CONFIRMED, False: Status.TENTATIVE}
    script = [
        [follow(car, status=status[k is not None and i >= k]) for car, k in zip(cars, frames, strict=True)]
        for i in range(FRAMES)
    ]
    return metrics_of([cars] * FRAMES, script)


def test_time_to_confirm_is_from_the_first_graded_frame_to_the_first_hit():
    metrics = confirmed_after(4)
    assert values(metrics, "time_to_confirm_s", "never_confirmed") == pytest.approx([4 * DT, 0.0])
    assert values(confirmed_after(0), "time_to_confirm_s") == [0.0]


def test_vehicles_that_are_never_confirmed_count_as_infinitely_late():
    metrics = confirmed_after(1, 2, 5, None, None)
    assert values(metrics, "time_to_confirm_s", "never_confirmed") == pytest.approx([5 * DT, 0.4])
    assert metrics["track.time_to_confirm_s"].n == 5
    metric = metrics["track.time_to_confirm_p90_s"]
    assert (metric.value, metric.reason) == (None, "too many vehicles were never confirmed")
    assert values(confirmed_after(0, *range(9)), "time_to_confirm_p90_s") == pytest.approx([7 * DT])
    assert values(confirmed_after(1, None, None), "time_to_confirm_s") == [None]


def test_the_clock_starts_when_the_vehicle_is_graded():
    scene = [[Body(0, 10.0, 5.0, points=9 if i < 3 else 20)] for i in range(FRAMES)]
    script = [[follow(CAR, status=Status.CONFIRMED if i >= 5 else Status.TENTATIVE)] for i in range(FRAMES)]
    assert values(metrics_of(scene, script), "time_to_confirm_s") == pytest.approx([2 * DT])


def test_a_track_beside_the_vehicle_confirms_nothing():
    """Its overlap is 3.6 / 8.6 of a length."""
    metrics = metrics_of([[CAR]] * 2, [[follow(CAR, x=12.0)]] * 2)
    assert values(metrics, "never_confirmed") == [1.0]


def test_bands_are_those_of_the_first_graded_frame():
    scene = [[Body(0, 14.0 + i, 0.0, 0.0, 12.5)] for i in range(FRAMES)]
    script = [[] if i < 3 else [follow(body)] for i, (body,) in enumerate(scene)]
    metrics = metrics_of(scene, script)
    names = (*(f"time_to_confirm_s{{{band}}}" for band in ("range=0-15", "range=15-30", "class=car")),)
    assert values(metrics, *names) == pytest.approx([3 * DT, None, 3 * DT])


# --- missed vehicles


def test_missed_shares_of_standing_and_long_vehicles():
    """The parked car is missed in 4 of 10 frames, the bus in all, the moving car in none."""
    bus = Body(1, 25.0, 5.0, 0.0, 5.0, size=(12.0, 2.5, 3.0), kind=Kind.BUS)
    moving = Body(2, 10.0, -5.0, 0.0, 5.0)
    script = [[follow(moving), *([follow(CAR)] if i >= 4 else [])] for i in range(FRAMES)]
    metrics = metrics_of([[CAR, bus, moving]] * FRAMES, script)
    names = ("missed_share", "missed_share_standing", "missed_share_long", "missed_share{class=bus}")
    assert values(metrics, *names) == pytest.approx([14 / 30, 0.4, 1.0, 1.0])
    assert metrics["track.missed_share"].n == 30
    assert values(metrics, "missed") == [14]


def test_a_vehicle_stands_until_it_first_moves():
    """It stands for 4 frames, moves for 3 and stands again; only the first 4 count, of which 1 is missed."""
    speed = [0.0] * 4 + [5.0] * 3 + [0.0] * 3
    scene = [[Body(0, 10.0, 5.0, 0.0, v)] for v in speed]
    metrics = metrics_of(scene, [[] if i in (0, 5, 9) else [follow(CAR)] for i in range(FRAMES)])
    assert (metrics["track.missed_share_standing"].value, metrics["track.missed_share_standing"].n) == (0.25, 4)


@pytest.mark.parametrize(("points", "n"), [(5, 0), (0, 8)], ids=["seen moving", "moved unseen"])
def test_standing_is_from_first_sight(points, n):
    """The car moves in its first two frames, with few points or none."""
    scene = [[Body(0, 10.0, 5.0, 0.0, 5.0 if i < 2 else 0.0, points=points if i < 2 else 20)] for i in range(FRAMES)]
    assert metrics_of(scene, [[]] * FRAMES)["track.missed_share_standing"].n == n


# --- false tracks


def test_false_tracks_are_on_nothing_ill_fitting_or_duplicates():
    """Beside a hit: a track far from all, one of a third of the car, and a second one on the car."""
    third = Estimate(8, 10.0, -5.0, 0.0, (1.5, 1.8))
    other = Body(1, 10.0, -5.0)
    estimates = [follow(CAR), Estimate(7, 0.0, 25.0), third, follow(CAR, track_id=9)]
    metrics = metrics_of([[CAR, other]] * FRAMES, [estimates] * FRAMES)
    names = ("false", "false_on_nothing", "false_ill_fitting", "false_duplicate")
    assert values(metrics, *names) == [3 * FRAMES, FRAMES, FRAMES, FRAMES]
    assert values(metrics, "false_share", "missed") == pytest.approx([1.5, FRAMES])


def test_a_track_that_only_touches_an_ungraded_vehicle_is_ill_fitting():
    """The union is 9 m of length, of which both have 0.2 m."""
    hidden = Body(1, 20.0, 0.0, points=3)
    metrics = metrics_of([[CAR, hidden]], [[follow(CAR), Estimate(7, 24.4, 0.0)]])
    assert values(metrics, "false_ill_fitting", "false_on_nothing", "false_share") == [1, 0, 1.0]


def test_without_vehicles_or_tracks_there_is_a_reason():
    metrics = metrics_of([[CAR]], [[]])
    assert metrics["track.false_on_nothing"].reason == "no track was reported in the graded range"
    assert values(metrics, "false_share", "missed_share", "never_confirmed") == [0.0, 1.0, 1.0]
