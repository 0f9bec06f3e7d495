import math
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from support.frames import Body, Scripted, drive, follow, grade_run

from luxloop.scenarios.grading.mma_metrics import band, mahalanobis_squared, switch_latencies
from luxloop.sim.world import Mode
from luxloop.tracker.records import MODELS, Status


def one_car(frames=10, speed=5.0, yaw=0.6):
    return [[Body(0, *drive(12.0, 4.0, yaw, speed, i), yaw, speed)] for i in range(frames)]


def run(scene, ego=None, **changes):
    script = [[follow(body, **changes) for body in bodies] for bodies in scene]
    return grade_run(scene, Scripted(script), **({"ego": ego} if ego else {}))[0]


def test_errors_of_each_model_and_of_the_selection_are_in_ego_axes():
    # The ego heads along y of world and odometry: ego x is world y, ego y is minus world x.
    def ego(_):
        return (0.0, 0.0, math.pi / 2), (0.0, 0.0, math.pi / 2)

    metrics = run(one_car(), ego=ego, model_offset=(0.3 + 0.1j, 0.2j, -0.5 + 0j))
    found = {
        model: [metrics[f"mma.{axis}_abs_mean_m{{model={model},target=moving}}"].value for axis in "xy"]
        for model in (*MODELS, "mma")
    }
    assert found["stationary"] == pytest.approx([0.1, 0.3])
    assert found["cv"] == pytest.approx([0.2, 0.0], abs=1e-9)
    assert found["ca"] == pytest.approx([0.0, 0.5], abs=1e-9)
    assert found["mma"] == pytest.approx([0.0, 0.0], abs=1e-9)
    assert metrics["mma.x_abs_std_m{model=cv,target=moving}"].value == pytest.approx(0.0, abs=1e-9)
    assert metrics["mma.x_abs_mean_m{model=cv,target=standing}"].value is None


@pytest.mark.parametrize("quarters", [0, 1, 2, 3])
@pytest.mark.parametrize("corner", [(1, 1), (-1, 1), (1, -1)])
def test_tracked_corner_is_matched_for_any_side_taken_as_front(quarters, corner):
    # The track has the true rectangle with another side as front; its corners are exact.
    size = (1.8, 4.6) if quarters % 2 else (4.6, 1.8)
    heading = 0.6 + quarters * math.pi / 2 + 0.1
    scene = one_car()
    metrics = run(scene, heading=heading, size=size, corner=corner)
    # The remaining error is the 0.1 rad of heading: the corner moves by the chord.
    swing = math.hypot(4.6, 1.8) * math.sin(0.05)
    errors = [metrics[f"mma.{axis}_abs_mean_m{{target=moving}}"].value for axis in "xy"]
    assert math.hypot(*errors) == pytest.approx(swing)


def test_only_confirmed_tracks_are_judged():
    metrics = run(one_car(), status=Status.COASTING)
    assert metrics["mma.mode_accuracy"].value is None
    assert "confirmed" in metrics["mma.mode_accuracy"].reason


def test_mode_accuracy_and_stationary_targets():
    standing = one_car(speed=0.0)
    assert run(standing, model=0)["mma.mode_accuracy"].value == 1.0
    assert run(standing, model=1)["mma.mode_accuracy"].value == 0.0
    metrics = run(standing, model_offset=(0.25, 0, 0))
    assert metrics["mma.x_abs_mean_m{model=stationary,target=standing}"].value == pytest.approx(0.25)
    assert metrics["mma.x_abs_mean_m{target=moving}"].value is None


def test_chi_square_band_equals_the_textbooks():
    # Bar-Shalom, Li and Kirubarajan 2001, section 5.4.2: two-sided 95 % region of chi-square with 2 dof.
    assert band(0.95) == pytest.approx((0.0506, 7.378), abs=1e-3)


@pytest.mark.parametrize(("error_m", "inside"), [(0.02, 0.0), (0.05, 1.0), (0.26, 1.0), (0.28, 0.0)])
def test_nees_in_band(error_m, inside):
    # Variance 0.01 m^2: the band is 0.0225 to 0.2716 m of distance.
    scene = one_car()
    script = [[follow(b, x=b.x + error_m)] for (b,) in scene]
    assert grade_run(scene, Scripted(script))[0]["mma.nees_in_band"].value == inside


def test_nees_of_a_correlated_and_of_an_invalid_covariance():
    covariance = np.array([[[4.0, 1.0], [1.0, 2.0]], [[1.0, 2.0], [2.0, 1.0]], [[0.0, 0.0], [0.0, 0.0]]])
    error = np.array([[1.0, 2.0]] * 3)
    expected = error[0] @ np.linalg.inv(covariance[0]) @ error[0]
    np.testing.assert_allclose(mahalanobis_squared(error, covariance), [expected, np.inf, np.inf])


def test_confusion_rates_and_stationary_accuracy():
    """Of four standing frames one is selected as cv; of four accelerating ones two are cv and one is stationary."""
    modes = [Mode.STATIONARY] * 4 + [Mode.ACCELERATING] * 4
    scene = [[Body(0, 12.0, 4.0, mode=mode)] for mode in modes]
    script = [[follow(body, model=m)] for (body,), m in zip(scene, [0, 0, 0, 1, 1, 1, 0, 2], strict=True)]
    metrics = grade_run(scene, Scripted(script))[0]
    found = {mode: [metrics[f"mma.selected{{mode={mode},model={model}}}"].value for model in MODELS] for mode in MODELS}
    assert found == {"stationary": [0.75, 0.25, 0.0], "cv": [None] * 3, "ca": [0.25, 0.5, 0.25]}
    assert metrics["mma.selected{mode=ca,model=cv}"].n == 4
    assert "cv" in metrics["mma.selected{mode=cv,model=ca}"].reason
    assert metrics["mma.mode_accuracy"].value == 0.5
    assert metrics["mma.stationary_accuracy"].value == 6 / 8


def test_gain_is_relative_to_the_best_single_model():
    """Fails when it is relative to the mean of the models, or by one axis: cv is best by distance, ca on the x axis."""
    single = [complex(3, 4), complex(0.3, 0.4), complex(0.2, 0.6)]
    chosen = complex(0.24, 0.32)
    offsets = tuple(error - chosen for error in single)
    scene = one_car()
    script = [[follow(b, x=b.x + chosen.real, y=b.y + chosen.imag, model_offset=offsets)] for (b,) in scene]
    metrics = grade_run(scene, Scripted(script))[0]
    assert metrics["mma.gain{target=moving}"].value == pytest.approx(1 - 0.4 / 0.5)
    assert metrics["mma.gain{target=standing}"].value is None


class WithModelCovariances(Scripted):
    """Scripted tracker that reports the variances of its models, 1, 4 and 9 cm^2, and their NIS, 1, 2 and NaN."""

    def step(self, scan):
        tracks, trace = super().step(scan)
        each = (len(tracks), 1, 1, 1)
        covariance = np.tile(np.eye(2)[None] * np.array([1.0, 4.0, 9.0])[:, None, None] * 1e-4, each)
        return replace(
            tracks, model_covariance_odom=covariance, model_nis=np.tile([1.0, 2.0, np.nan], each[:2])
        ), trace  # fmt: skip


def test_each_model_is_graded_with_its_own_covariance_while_it_is_the_true_mode():
    """Fails when a model's error is graded with the covariance, or in the frames, of another model."""
    scene = [[Body(0, 12.0, 4.0, mode=mode)] for mode in (Mode.STATIONARY, Mode.CONSTANT_VELOCITY, Mode.ACCELERATING)]
    script = [[follow(body, model_offset=(0.01j, 0.06 + 0j, 0.03 + 0.03j))] for (body,) in scene]
    metrics, tables, _ = grade_run(scene, WithModelCovariances(script))
    np.testing.assert_allclose(tables["tracks"][[f"{m}_nees" for m in MODELS]], [[1.0, 9.0, 2.0]] * 3)
    means = [metrics[f"mma.nees_mean{{model={model}}}"].value for model in MODELS]
    assert means == pytest.approx([1.0, 9.0, 2.0])
    assert [metrics[f"mma.nees_in_band{{model={model}}}"].value for model in MODELS] == [1.0, 0.0, 1.0]
    assert [metrics[f"mma.nees_mean{{model={model}}}"].n for model in MODELS] == [1, 1, 1]
    assert [metrics[f"mma.nis_mean{{model={model}}}"].value for model in MODELS] == [1.0, 2.0, None]
    assert metrics["mma.nis_in_band{model=cv}"].value == 1.0


def test_tracker_without_model_covariances_has_no_model_consistency():
    metrics = run(one_car())
    assert metrics["mma.nees_in_band{model=cv}"].value is metrics["mma.nis_mean{model=cv}"].value is None
    assert (
        metrics["mma.nees_in_band{model=cv}"].reason
        == "the tracker does not report its covariance or the nees of its models"
    )
    assert metrics["mma.nees_in_band{model=ca}"].reason.endswith("with model ca")


def test_mean_nees_excludes_infinite_values():
    """Fails when one invalid covariance makes the mean infinite, or counts as inside the band."""
    scene = one_car(frames=4)
    variances = [0.01, 0.01, 0.01, 0.0]
    script = [[follow(b, x=b.x + 0.2, position_variance=v)] for (b,), v in zip(scene, variances, strict=True)]
    metrics = grade_run(scene, Scripted(script))[0]
    assert (metrics["mma.nees_mean"].value, metrics["mma.nees_mean"].n) == (pytest.approx(4.0), 3)
    assert metrics["mma.nees_in_band"].value == 0.75


class Elongated(Scripted):
    """Scripted tracker with a small variance along odometry y and a large one along odometry x."""

    def step(self, scan):
        tracks, trace = super().step(scan)
        tracks.covariance[:, 0, 0], tracks.covariance[:, 1, 1] = 0.25, 1e-4
        return tracks, trace


def test_nees_is_computed_in_the_odometry_frame_of_the_covariance():
    # 0.5 m off along odometry x, a variance of 0.25 m^2 there; the ego is turned by 90 degrees.
    scene = one_car()
    turned = ((0.0, 0.0, math.pi / 2), (0.0, 0.0, math.pi / 2))
    script = [[follow(b, x=b.x + 0.5)] for (b,) in scene]
    _, tables, _ = grade_run(scene, Elongated(script), ego=lambda _: turned)
    np.testing.assert_allclose(tables["tracks"].nees, 1.0)


def test_true_modes_have_the_names_of_the_models():
    scene = [[Body(0, 12.0, 4.0, mode=mode)] for mode in Mode]
    _, tables, _ = grade_run(scene, Scripted([[follow(body)] for (body,) in scene]))
    assert list(tables["truth"]["mode"]) == list(tables["tracks"]["true_mode"]) == list(MODELS)
    unmatched = grade_run(scene, Scripted([[follow(body, x=40.0)] for (body,) in scene]))[1]["tracks"]
    assert unmatched["true_mode"].isna().all()


def judged(frame, true, model, actor=0):
    return pd.DataFrame(
        {
            "frame": frame,
            "actor_id": actor,
            "true_mode": pd.Categorical.from_codes(true, list(MODELS)),
            "model": pd.Categorical.from_codes(model, list(MODELS)),
        }
    )


def test_switch_latency_from_the_true_change_to_the_selection():
    rows = judged(range(8), true=[1, 1, 0, 0, 0, 2, 2, 2], model=[1, 1, 1, 1, 0, 2, 2, 2])
    assert switch_latencies(rows) == [(0, 2.0), (0, 0.0)]


def test_latency_without_selection_is_infinite_and_unobserved_changes_do_not_count():
    never = judged(range(5), true=[1, 1, 0, 0, 1], model=[1] * 5)
    assert switch_latencies(never) == [(0, np.inf), (0, 0.0)]
    unseen = judged([0, 1, 7, 8], true=[1, 1, 0, 0], model=[1] * 4)
    assert switch_latencies(unseen) == []


def test_median_latency_and_missing_latency():
    # Stationary for 24 frames, then accelerating: the model `ca`.
    scene = [[Body(0, 12.0, 4.0, mode=Mode.ACCELERATING if i >= 24 else Mode.STATIONARY)] for i in range(50)]

    def latency(model):
        script = [[follow(body, model=model(i)) for body in bodies] for i, bodies in enumerate(scene)]
        return grade_run(scene, Scripted(script))[0]["mma.switch_latency_frames"]

    followed = latency(lambda i: 0 if i < 28 else 2)
    assert (followed.value, followed.n) == (4.0, 1)
    assert latency(lambda _: 0).value is None
    assert "never selected" in latency(lambda _: 0).reason
    standing = run(one_car(speed=0.0))["mma.switch_latency_frames"]
    assert (standing.value, standing.n) == (None, 0)
