"""The one list of all metrics: name, unit and meaning. Results and `[expect]` tables use these names only.

This module imports quickly, because scenario files are validated against it.
"""

import math
from collections.abc import Container, Iterable, Iterator
from itertools import product

from luxloop.scenarios.grading import emergence_names, track_metric_names
from luxloop.scenarios.grading.metric_definition import Definition, register
from luxloop.scenarios.grading.track_metric_names import RANGE_BANDS, SEEN, VIEWS
from luxloop.scenarios.grading.truth_events import event_names
from luxloop.scenarios.grading.vulnerable import vulnerable_names
from luxloop.sensor_model.truth import Cause
from luxloop.tracker.records import BASELINES, METHODS, MODEL_NAMES, MODELS, PREDICTION_S, TURNING_MODELS

CANDIDATES = (*METHODS, *BASELINES)
"""Methods with graded rectangles."""

FIT_METHODS = (*CANDIDATES, "best", "oracle")
"""`best` is the tracker's selection, `oracle` the one of `METHODS` with the least heading error."""

CAUSES = {cause: cause.name.lower() for cause in Cause if cause != Cause.CLEAN}

ESTIMATES = (*MODELS, "mma")
"""Graded position estimates: each standard motion model, and the selection by multiple-model association."""

HORIZONS = dict(zip(("500ms", "1s", "2s"), PREDICTION_S, strict=True))
"""Times of graded predictions [s], by their names in metrics."""

TARGETS = ("stationary_target", "moving_target")

TIMED_STAGES = ("sim", "sensor", "tracker")
"""Timed stages of the run loop. For traffic in a separate process, the waiting time is measured."""

DRIVERS = {"tracks": "", "truth": "truth_"}
"""Input of the ego's controller, with the prefix of its metrics."""

SAFETY = {
    "min_ttc_s": ("s", "least true time to collision with an actor in the ego's path"),
    "min_gap_m": ("m", "least true gap to an actor in the ego's path"),
    "max_deceleration_mps2": ("m/s^2", "largest true deceleration of the ego"),
    "collisions": ("count", "actors that the ego collided with"),
}
"""Unit and meaning of the safety metrics of each drive of a controlled ego."""


REGRET = "mean absolute heading error of best minus that of oracle"

POINT_BANDS = {"0_30": (0.0, 30.0), "30_100": (30.0, 100.0), "100_up": (100.0, math.inf)}
"""Bands of the number of points of an observation's segment, the upper end excluded."""

COVERAGES = (50, 90, 99)
"""Central intervals of the heading's normal distribution whose coverage is graded [%]."""

CORNER_FIGURES = {
    "corner_along": "nearest corner along the vehicle, positive beyond the true box",
    "corner_across": "nearest corner across the vehicle, positive beyond the true box",
    "extent_along": "rectangle's extent minus that of the vehicle's true points, along the vehicle",
    "extent_across": "rectangle's extent minus that of the vehicle's true points, across the vehicle",
}
"""Errors of corner and size with their meanings."""


def estimates(models: Iterable[str]) -> tuple[str, ...]:
    """Return the names of the graded estimates of a run with these models."""
    return (*models, "mma")


def models_among(names: Container[str], pattern: str = "mma.{}.prediction_1s_abs_mean_m") -> tuple[str, ...]:
    """Return the standard models, and all others for which the `pattern` with its name is among `names`."""
    return tuple(model for model in MODEL_NAMES if model in MODELS or pattern.format(model) in names)


def _dataset() -> Iterator[Definition]:
    yield Definition("dataset.vehicles", "count", "vehicles that were graded at least once")
    yield Definition("dataset.observations", "count", "graded vehicles, summed over frames")
    yield Definition("dataset.frames", "count", "frames that were graded")
    yield Definition("dataset.observations_per_vehicle", "1", "observations over vehicles")
    yield Definition("dataset.observations_per_frame", "1", "observations over frames")
    yield Definition("dataset.points_per_observation", "1", "points of a graded vehicle in a frame, mean")
    for view in SEEN:
        yield Definition(f"dataset.{view}.observations", "count", f"observations of view {view}")
        yield Definition(f"dataset.{view}.share", "1", f"share of view {view} in all observations")


def _fit() -> Iterator[Definition]:
    for scope, method in product(("", *(f"{view}." for view in VIEWS.values())), FIT_METHODS):
        prefix = f"fit.{scope}{method}"
        yield Definition(f"{prefix}.heading_mean_deg", "deg", "mean heading error modulo 90 degrees")
        yield Definition(f"{prefix}.heading_std_deg", "deg", "STD of the heading error modulo 90 degrees")
        yield Definition(f"{prefix}.heading_abs_mean_deg", "deg", "mean absolute heading error")
        yield Definition(f"{prefix}.heading_abs_std_deg", "deg", "STD of the absolute heading error")
        yield Definition(f"{prefix}.rounded_to_0deg", "1", "share of heading errors that are 0 in whole degrees")
        for limit in range(1, 6):
            yield Definition(f"{prefix}.within_{limit}deg", "1", f"share of heading errors <= {limit} degrees")
        yield Definition(f"{prefix}.position_abs_mean_m", "m", "mean distance of the nearest corner to the true one")
        yield Definition(f"{prefix}.iou_mean", "1", "mean bird's-eye overlap of rectangle and true box")
    yield Definition("fit.best.coverage", "1", "share of the data set's observations with a fitted rectangle")
    for band, method in product(_bands(), FIT_METHODS):
        yield Definition(f"fit.{method}.heading_abs_mean_deg.{band}", "deg", "mean absolute heading error")
    for band in _bands():
        yield Definition(f"fit.best.regret_deg.{band}", "deg", REGRET)
    for scope in ("", *(f"{view}." for view in VIEWS.values())):
        yield from _best(f"fit.{scope}best")


def _bands() -> list[str]:
    """Return the ends of the names of metrics by range and by number of points."""
    return [*(f"by_range.{band}" for band in RANGE_BANDS), *(f"by_points.{band}" for band in POINT_BANDS)]


def _best(prefix: str) -> Iterator[Definition]:
    """Yield the metrics of the selected rectangle alone."""
    yield Definition(f"{prefix}.regret_deg", "deg", REGRET)
    for name, meaning in CORNER_FIGURES.items():
        yield Definition(f"{prefix}.{name}_mean_m", "m", f"mean error: {meaning}")
        yield Definition(f"{prefix}.{name}_abs_mean_m", "m", f"mean absolute error: {meaning}")
    for percent in COVERAGES:
        meaning = f"share of true headings inside the {percent} % interval of the box's heading variance"
        yield Definition(f"{prefix}.coverage_{percent}", "1", meaning)
    yield Definition(
        f"{prefix}.bound_ratio", "1", "mean absolute heading error over that of normal errors at the bound"
    )


def _stages() -> Iterator[Definition]:
    yield Definition("segmentation.over_rate", "1", "graded vehicles split over two or more segments")
    yield Definition("segmentation.under_rate", "1", "segments of graded vehicles merged with another object")
    yield Definition("segmentation.missed_rate", "1", "graded vehicles without a segment with most of their points")
    for cause in CAUSES.values():
        yield Definition(f"outliers.{cause}.precision", "1", "removed points of this cause, over these and clean ones")
        yield Definition(f"outliers.{cause}.recall", "1", "points of this cause that were removed")


def _estimates(names: Iterable[str]) -> Iterator[Definition]:
    for estimate in names:
        for target, axis in product(TARGETS, "xy"):
            prefix = f"mma.{estimate}.{target}.{axis}_abs"
            what = f"of the tracked corner, ego {axis} axis"
            yield Definition(f"{prefix}_mean_m", "m", f"mean absolute error {what}")
            yield Definition(f"{prefix}_std_m", "m", f"STD of the absolute error {what}")
        for label, seconds in HORIZONS.items():
            prefix = f"mma.{estimate}.prediction_{label}_abs_mean_m"
            what = f"mean distance of the tracked corner from its prediction {seconds:g} s ahead"
            yield Definition(prefix, "m", what)
            yield Definition(f"{prefix}_around_changes", "m", f"{what}, within 1 s of a change of the true mode")


def _models(models: Iterable[str]) -> Iterator[Definition]:
    for mode, model in product(MODELS, models):
        yield Definition(
            f"mma.confusion.{mode}.{model}", "1", f"share of true {mode} frames in which {model} is selected"
        )


def _mma() -> Iterator[Definition]:
    yield from _estimates(ESTIMATES)
    for target in TARGETS:
        meaning = "reduction of the mean distance from the true corner relative to the best single model"
        yield Definition(f"mma.gain.{target}", "1", meaning)
    yield Definition("mma.mode_accuracy", "1", "share of frames in which the selected model is the true mode")
    yield Definition("mma.stationary_accuracy", "1", "share of frames with the correct decision on standing or moving")
    yield from _models(MODELS)
    yield Definition("mma.switch_latency_frames", "count", "median frames from a true change of mode to its selection")
    yield Definition("mma.nees_in_band", "1", "share of position NEES inside the two-sided chi-square band, 2 dof")
    yield Definition("mma.nees_mean", "1", "mean position NEES, 2 for a consistent filter")
    yield from _consistency(MODELS)


def _consistency(models: Iterable[str]) -> Iterator[Definition]:
    for model, measure in product(models, ("nees", "nis")):
        prefix, what = f"mma.{model}.{measure}", f"{measure.upper()} of the model alone, while it is the true mode"
        yield Definition(f"{prefix}_in_band", "1", f"share of {what}, inside the band")
        yield Definition(f"{prefix}_mean", "1", f"mean {what}")


def _control() -> Iterator[Definition]:
    for driver, prefix in DRIVERS.items():
        for name, (unit, meaning) in SAFETY.items():
            yield Definition(f"control.{prefix}{name}", unit, f"{meaning}, controlled by the {driver}")


def _performance() -> Iterator[Definition]:
    for stage, quantile in product(TIMED_STAGES, ("p50", "p99")):
        yield Definition(f"perf.{stage}_ms_{quantile}", "ms", f"time per frame in the {stage}, {quantile}")
    yield Definition("perf.realtime_factor", "1", "simulated time over wall-clock time of the whole loop")


GRADED = register(
    [
        *(*_dataset(), *_fit(), *_stages(), *_mma()),
        *(*track_metric_names.definitions(), *emergence_names.definitions(), *event_names.definitions()),
        *vulnerable_names.definitions(),
    ]
)
"""Metrics of `Grader.finish`; every run has all of them."""

TURNING = register([*_estimates(TURNING_MODELS), *_models(TURNING_MODELS), *_consistency(TURNING_MODELS)])
"""Metrics of models beyond the standard set; a run has those of its own models."""

CONTROL = register(_control())
"""Metrics of `control.safety.grade`; every run has all of them."""

REGISTRY = register([*GRADED.values(), *TURNING.values(), *CONTROL.values(), *_performance()])
"""All metrics of a result, with those of `perf`, which the run loop measures."""

METRICS: dict[str, str] = {name: definition.unit for name, definition in REGISTRY.items()}
"""Unit of every metric by name."""
