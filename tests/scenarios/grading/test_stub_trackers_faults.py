"""A fault planted in the output of the shipped tracker changes the metrics that should detect it, and no others.

All runs are of one scene that exercises every stage, or of its variant with exact fits; only the fault differs.
"""

from functools import cache, partial

import numpy as np
import pytest
from support import planted_faults, shared_scans, short_run
from support.many_metrics import METRICS, SINGLE_FITS

from luxloop.scenarios.grading.mma_metrics import band
from luxloop.tracker.records import MODELS

SCENE = """\
description = "Cars from all sides, standing, driving, braking and starting, among outliers."
duration_s = 4.0
[noise.outliers]
enabled = true
rate = 0.02
[traffic]
kind = "scripted"
[[traffic.actor]]
x_m = 9
y_m = 4
yaw_deg = 25
[[traffic.actor]]
x_m = -16
y_m = 5
motion = [{ kind = "straight", speed_mps = 8 }]
[[traffic.actor]]
x_m = 25
y_m = -5
yaw_deg = 180
motion = [{ kind = "straight", speed_mps = 10, acceleration_mps2 = -2.0 }]
[[traffic.actor]]
x_m = 18
y_m = 0
motion = [{ kind = "stop-and-go", peak_speed_mps = 4, go_s = 1.6, stop_s = 1.0 }]
"""
PLAIN = (
    SCENE.replace("[noise.outliers]\nenabled = true\nrate = 0.02", "[noise]\nideal = true")
    .replace("[traffic]\n", "[noise.layer_overlap]\nenabled = false\n[traffic]\n")
    .replace("yaw_deg = 25", "yaw_deg = -20")
    .replace("speed_mps = 8 }", "speed_mps = 7 }")
)
"""Variant with an ideal car, flat faces and no outliers: the fits are as exact as the noise of ranges permits, so that
biases and drifts of a few centimetres stand out. The standing car is turned so that its track is soon confirmed, and
the passing one is slower, so that it is followed for longer."""
CAUSES = ("mirror", "layer_overlap", "range_outlier")
"""Causes of noise in this scene."""


@pytest.fixture(scope="module", autouse=True)
def _scans_are_simulated_once():
    with shared_scans.shared():
        yield


@cache
def run(fault, scene=SCENE):
    return short_run.run(scene, fault)


def value(fault, name, scene=SCENE):
    return run(fault, scene).metrics[name].value


def sound(name, scene=SCENE):
    return value(planted_faults.Sound, name, scene)


def changed(fault, scene=SCENE):
    """Families of the metrics that the fault has changed."""
    names = [name for name in METRICS if not name.startswith("perf.")]
    return {name.split(".")[0] for name in names if not same(value(fault, name, scene), sound(name, scene))}


def same(a, b):
    return a == b if a is None or b is None else a == pytest.approx(b, abs=1e-9)


def test_scene_exercises_every_stage():
    """Otherwise an undetected fault would prove nothing."""
    assert all(
        0 < sound(f"outliers.{part}{{cause={cause}}}") < 1 for cause in CAUSES for part in ("recall", "precision")
    )
    assert all(run(planted_faults.Sound).metrics[f"mma.selected{{mode={mode},model=ca}}"].n > 30 for mode in MODELS)
    assert sound("fit.coverage") > 0.9
    assert sound("segmentation.missed_rate") == 0
    assert sound("segmentation.over_rate") < 0.01  # a dark car is split once


def test_exact_scene_exercises_the_fits_and_every_model():
    assert sound("fit.coverage", PLAIN) > 0.9
    assert sound("fit.within_2deg", PLAIN) > 0.9
    assert all(
        run(planted_faults.Sound, PLAIN).metrics[f"mma.selected{{mode={mode},model=ca}}"].n > 30 for mode in MODELS
    )


def test_biased_headings_change_the_fit_metrics():
    """The mean changes by exactly the bias; errors beyond 45 degrees wrap."""
    fault = planted_faults.BiasedFits
    biased, exact = partial(value, fault, scene=PLAIN), partial(sound, scene=PLAIN)
    assert changed(fault, PLAIN) == {"fit"}
    for method in ("closeness", "variance", "best"):
        name = f"fit.heading_mean_deg{{method={method}}}"
        errors = errors_of(planted_faults.Sound, method) + fault.bias_deg
        assert biased(name) == pytest.approx((errors - 90 * np.round(errors / 90)).mean(), abs=1e-9)
    assert biased("fit.heading_mean_deg") == pytest.approx(exact("fit.heading_mean_deg") + 3, abs=1e-9)
    assert biased("fit.within_2deg") < 0.1 < 0.9 < exact("fit.within_2deg")
    assert biased("fit.iou_mean") < exact("fit.iou_mean")
    assert biased("fit.bound_ratio") > 3 * exact("fit.bound_ratio")


def errors_of(fault, method):
    fits = run(fault, PLAIN).tables["fits"]
    rows = fits[fits[method]] if method == "best" else fits[fits["method"] == method]
    return rows["heading_error_deg"].dropna().to_numpy()


def test_bad_selection_changes_best_and_its_regret():
    """The single methods and the oracle do not change."""
    fault = planted_faults.WorstFits
    assert changed(fault) == {"fit"}
    assert all(same(value(fault, name), sound(name)) for name in SINGLE_FITS)
    assert value(fault, "fit.regret_deg") > 5 * sound("fit.regret_deg")
    lost = value(fault, "fit.heading_abs_mean_deg") - sound("fit.heading_abs_mean_deg")
    assert value(fault, "fit.regret_deg") - sound("fit.regret_deg") == pytest.approx(lost, abs=1e-9)


def test_split_segments_are_over_segmentation():
    """Every vehicle is in two parts of three and two fifths of its points, and no part contains other points."""
    fault = planted_faults.SplitSegments
    assert changed(fault) == {
        "segmentation",
        "outliers",
        "fit",
    }  # both are counted in the larger piece
    assert value(fault, "segmentation.over_rate") > 0.99
    assert value(fault, "segmentation.missed_rate") < 0.1
    assert same(value(fault, "segmentation.under_rate"), sound("segmentation.under_rate"))
    assert same(value(fault, "fit.heading_abs_mean_deg"), sound("fit.heading_abs_mean_deg"))


def test_merged_segments_are_under_segmentation():
    """At most one vehicle per frame can own the only segment."""
    fault = planted_faults.MergedSegments
    assert "segmentation" in changed(fault)
    assert changed(fault) <= {"segmentation", "outliers", "fit"}
    assert value(fault, "segmentation.under_rate") > 5 * sound("segmentation.under_rate")
    assert value(fault, "segmentation.over_rate") == value(fault, "segmentation.missed_rate") == 0
    graded = run(fault).metrics["dataset.observations"].value
    assert value(fault, "fit.coverage") <= run(fault).frames / graded


def test_vehicles_without_segments_are_missed():
    fault = planted_faults.NoSegments
    assert changed(fault) == {"segmentation", "outliers", "fit"}
    assert value(fault, "segmentation.missed_rate") == 1.0
    assert value(fault, "fit.coverage") == 0.0
    assert value(fault, "segmentation.under_rate") is None
    assert value(fault, "outliers.recall{cause=mirror}") is None


@pytest.mark.parametrize("cause", CAUSES)
def test_linkage_that_keeps_all_points_has_no_recall(cause):
    fault = planted_faults.KeepingLinkage
    assert changed(fault) == {"outliers"}
    assert value(fault, f"outliers.recall{{cause={cause}}}") == 0.0
    assert value(fault, f"outliers.precision{{cause={cause}}}") is None  # nothing was removed


@pytest.mark.parametrize("cause", CAUSES)
def test_linkage_that_removes_all_points_has_low_precision(cause):
    """The precision is the share of the cause in the points of the segments with this cause."""
    fault = planted_faults.RemovingLinkage
    assert changed(fault) == {"outliers"}
    assert value(fault, f"outliers.recall{{cause={cause}}}") == 1.0
    table = run(fault).tables["outliers"]
    rows = table[table["cause"] == cause]
    share = rows["points"].sum() / (rows["points"] + rows["clean_removed_beside"]).sum()
    assert value(fault, f"outliers.precision{{cause={cause}}}") == pytest.approx(share)
    assert share < 0.2


def test_constant_model_selection_changes_mode_and_position_metrics():
    """The mode is correct in accelerating frames, and positions are those of the single model."""
    fault = planted_faults.AlwaysAccelerating
    chosen, exact = partial(value, fault, scene=PLAIN), partial(sound, scene=PLAIN)
    assert changed(fault, PLAIN) == {"mma", "track"}  # boxes are anchored at the corner, so their overlaps change
    judged = run(fault, PLAIN).tables["tracks"].query("judged")
    accelerating = (judged["true_mode"] == "ca").mean()
    assert chosen("mma.mode_accuracy") == pytest.approx(accelerating)
    assert chosen("mma.mode_accuracy") < exact("mma.mode_accuracy") - 0.2
    assert [chosen(f"mma.selected{{mode={mode},model=ca}}") for mode in MODELS] == [1.0] * 3
    assert chosen("mma.stationary_accuracy") == pytest.approx((judged["true_mode"] != "stationary").mean())
    assert value(fault, "mma.switch_latency_frames") == 0.0  # of changes to acceleration; it follows no other
    assert sound("mma.switch_latency_frames") is not None
    for target in ("standing", "moving"):
        single = chosen(f"mma.x_abs_mean_m{{model=ca,target={target}}}")
        assert chosen(f"mma.x_abs_mean_m{{target={target}}}") == pytest.approx(single)
    standing = run(fault, PLAIN).tables["tracks"].query("judged and true_mode == 'stationary'")
    off = [np.hypot(standing[f"{mode}_x_error_m"], standing[f"{mode}_y_error_m"]).mean() for mode in MODELS]
    assert chosen("mma.gain{target=standing}") == pytest.approx(1.0 - off[MODELS.index("ca")] / min(off))
    assert chosen("mma.gain{target=standing}") < 0.0 < exact("mma.gain{target=standing}")
    assert chosen("mma.gain{target=standing}") < exact("mma.gain{target=standing}") - 0.5


def test_overconfidence_changes_nees_only():
    """Covariances four times too small: NEES is four times as large, NIS and positions do not change."""
    fault = planted_faults.Overconfident
    assert changed(fault) == {"mma"}
    nees = [name for name in METRICS if ".nees_" in name]
    others = [name for name in METRICS if name.startswith("mma.") and name not in nees]
    assert all(same(value(fault, name), sound(name)) for name in others)
    for name in nees:
        if "_mean" in name:
            assert value(fault, name) == pytest.approx(fault.factor * sound(name))
    before = run(planted_faults.Sound).tables["tracks"].query("judged")["nees"] * fault.factor
    assert value(fault, "mma.nees_in_band") == pytest.approx(before.between(*band(0.95)).mean())
