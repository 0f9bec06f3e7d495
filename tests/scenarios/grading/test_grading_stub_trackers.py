"""Metrics of stub trackers with one known fault each: only the expected metrics change, by the expected amount."""

import pytest
from support.frames import Body, drive, grade_run
from support.stub_trackers import BiasedYaw, Forgetful, GhostMaking, IdSwapping, OneFrameLate, Perfect

FRAMES = 50
SPEED = 10.0
HIDDEN = range(20, 30)


def scene():
    """Three cars pass a standing ego at 10 m/s, one of them hidden for ten frames; a fourth is parked."""
    cars = []
    for i in range(FRAMES):
        seen = i not in HIDDEN
        cars.append(
            [
                Body(0, *drive(-20.0, 5.0, 0.0, SPEED, i), 0.0, SPEED),
                Body(1, *drive(20.0, -5.0, 3.0, SPEED, i), 3.0, SPEED),
                Body(2, *drive(-25.0, 9.0, 0.0, SPEED, i), 0.0, SPEED, points=20 * seen, visible=float(seen)),
                Body(3, 10.0, -12.0, 1.0),
            ]
        )
    return cars


MOVING_X, STANDING_X = (f"mma.x_abs_mean_m{{target={motion}}}" for motion in ("moving", "standing"))


def graded(tracker_type, **options):
    cars = scene()
    metrics, _, _ = grade_run(cars, tracker_type(**options))
    return {name: metrics[name].value for name in (*metrics, MOVING_X, STANDING_X)}


@pytest.fixture(scope="module")
def perfect():
    return graded(Perfect)


def test_perfect(perfect):
    ones = ("hota", "mota", "idf1", "loca", "occlusion_survival")
    assert [perfect[f"track.{name}"] for name in ones] == pytest.approx([1.0] * 5)
    assert perfect[MOVING_X] == pytest.approx(0.0, abs=1e-9)


def test_one_frame_late_has_the_error_of_one_frame_of_motion():
    late = graded(OneFrameLate)
    # 0.8 m of 4.6 m: an overlap of 3.8 / 5.4 = 0.70, which reaches 14 of HOTA's 19 thresholds.
    assert late["track.hota"] == pytest.approx(14 / 19, abs=0.12)
    assert late["track.hota"] < 0.9
    assert late["track.mota"] == 1.0
    assert late[MOVING_X] == pytest.approx(0.8, rel=0.03)
    assert late[STANDING_X] == pytest.approx(0.0, abs=1e-9)
    assert late["track.id_switches"] == 0


def test_swapped_ids_lower_identity_and_not_detection(perfect):
    swapped = graded(IdSwapping, pair=(0, 1), at=FRAMES // 2)
    assert swapped["track.id_switches"] == 2
    # Two cars of 50 frames keep their id for half of them; the 90 frames of the others are correct.
    assert swapped["track.idf1"] == pytest.approx((50 + 90) / 190)
    assert swapped["track.deta"] == pytest.approx(1.0)
    assert swapped["track.assa"] == pytest.approx((100 / 3 + 90) / 190)
    assert swapped["mma.nees_in_band"] == perfect["mma.nees_in_band"]


@pytest.mark.parametrize(("bias_deg", "flips"), [(5.0, 0.0), (-20.0, 0.0), (180.0, 1.0)])
def test_biased_yaw_changes_the_heading_error(bias_deg, flips):
    biased = graded(BiasedYaw, bias_deg=bias_deg)
    assert biased["track.heading_abs_mean_deg"] == pytest.approx(abs(bias_deg))
    assert biased["track.heading_flip_rate"] == flips
    assert biased["track.mota"] == 1.0
    assert (biased["track.hota"] > 0.99) == (bias_deg == 180.0)


def test_false_tracks_lower_precision_only():
    ghost = graded(GhostMaking)
    assert ghost["track.false"] == FRAMES
    assert ghost["track.missed"] == 0
    assert ghost["track.assa"] == pytest.approx(1.0)
    assert ghost["track.mota"] == pytest.approx((190 - 50) / 190)


def test_forgetful_tracker_loses_ids_behind_an_occluder():
    forgetful = graded(Forgetful)
    assert forgetful["track.occlusion_survival"] == 0.0
    assert forgetful["track.id_switches"] == 1
    assert forgetful["track.deta"] == pytest.approx(1.0)
