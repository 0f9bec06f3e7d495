"""The one list of all metrics. Results, expectations, comparisons, studies and reports use these names only.

This module imports quickly, because scenario files are validated with it.
"""

import math
from collections.abc import Iterable, Iterator
from difflib import get_close_matches
from functools import cache
from itertools import product
from typing import Any

from luxloop.scenarios.metrics.definition import (
    OF_VEHICLES,
    REQUIRED,
    Better,
    MetricDefinition,
    Selection,
    Statistic,
    select,
)
from luxloop.scenarios.metrics.former_names import present_name
from luxloop.sensor_model.truth import Cause, View
from luxloop.sim.world import VEHICLE_KINDS, Kind
from luxloop.tracker.records import BASELINES, METHODS, MODEL_NAMES, MODELS, PREDICTION_S

CANDIDATES = (*METHODS, *BASELINES)
"""Methods with graded rectangles."""
FIT_METHODS = ("best", *CANDIDATES, "oracle")
"""`best` is the tracker's selection, `oracle` the one of `METHODS` with the least heading error."""
ESTIMATES = ("mma", *MODEL_NAMES)
"""Graded position estimates: the selection by multiple-model association, and each motion model."""


def estimates(models: Iterable[str]) -> tuple[str, ...]:
    """Return the names of the graded estimates of a run with these models."""
    return (*models, "mma")


VIEWS = {View.L_SHAPE: "l_shape", View.SIDE: "side", View.REAR: "rear", View.FRONT: "front"}
NO_VIEW = "none"
"""View with too few points on every face."""
CLASSES = tuple(kind.name.lower() for kind in Kind if kind in VEHICLE_KINDS)
"""Classes of graded vehicles."""
CAUSES = {cause: cause.name.lower() for cause in Cause if cause != Cause.CLEAN}
HORIZONS = dict(zip(("500ms", "1s", "2s"), PREDICTION_S, strict=True))
"""Times of graded predictions [s], by their names in metrics."""
TARGETS = ("standing", "moving")
"""Motion of the tracked vehicle, by its true mode."""
TIMED_STAGES = ("sim", "sensor", "tracker")
"""Timed stages of the run loop. For traffic in a separate process, the waiting time is measured."""
DRIVERS = {"tracks": "", "truth": "truth_"}
"""Input of the ego's controller, with the prefix of its metrics."""
GROUPS = {"people": "pedestrian", "riders": "bicycle"}
"""Class of the vulnerable road users of each group. Motorcycles are vehicles."""

STAGES = {
    "first_beam": "first frame with a beam returned from it, a scan point",
    "enough_points": "first frame with points_min scan points on it",
    "tentative": "first frame with a track on it, tentative or confirmed",
    "confirmed": "first frame with a confirmed track on it",
    "located": "first frame with a confirmed track within located_position_m and located_heading_deg",
}
"""Stages of emergence, in the order in which they are usually reached."""
END = "end"
"""Last frame with the target: there, a stage that was not reached is censored."""
EMERGING = {"target": (), "vehicle": CLASSES, "bicycle": ("bicycle",), "person": ("pedestrian",)}
"""Classes of the actors of each group; the target is the actor named by `grading.target`."""

RANGE_BANDS = ("0-15", "15-30", "30-50")
"""Bands of the distance from the ego's centre to the vehicle's [m] that reports show."""
POINT_BANDS = ("0-30", "30-100", "100-")
"""Bands of the number of points of an observation's segment that reports show."""
REPORTED_BANDS: tuple[dict[str, str], ...] = (
    *({"range": value} for value in RANGE_BANDS),
    *({"class": value} for value in CLASSES),
    *({"view": value} for value in (*VIEWS.values(), NO_VIEW)),
)
"""Filters of the rows of reports by range, class and view."""

FIT_HEADING_DEG, TRACK_HEADING_DEG = 45.0, 180.0
"""Largest errors of headings modulo 90 and modulo 360 degrees."""
COVERAGES = (50, 90, 99)
"""Central intervals of the heading's normal distribution whose coverage is graded [%]."""
WITHIN_DEG = range(1, 6)
"""Limits of the shares of small heading errors, as in the paper's table III [deg]."""
LONG_M = 6.0
"""Length above which a vehicle is long [m]: trucks and buses, but no car or van of the usual sizes."""
SHORT_OCCLUSION_S = 2.0
"""Longest occlusion that `track.hidden_2s_survival` counts [s]."""

ANY, SHARE, POSITIVE = (-math.inf, math.inf), (0.0, 1.0), (0.0, math.inf)
NO_PAIR = "no confirmed track followed a graded vehicle"
NOT_REPORTED = "the tracker does not report this estimate"


def _signed(largest: float = math.inf) -> dict[str, Any]:
    """Return the arguments of a mean error with its sign."""
    return {"range": (-largest, largest), "better": ""}


def _dataset() -> Iterator[MetricDefinition]:
    def figure(name: str, unit: str, meaning: str, **other: Any) -> MetricDefinition:
        return MetricDefinition(
            f"dataset.{name}", unit, meaning, "dataset", statistic="given", better="", filters=OF_VEHICLES, **other
        )

    yield figure("vehicles", "count", "vehicles that were graded at least once")
    yield figure("observations", "count", "graded vehicles, summed over frames")
    yield figure("frames", "count", "frames that were graded")
    yield figure("share", "1", "share of the observations with this filter in all", range=SHARE)
    yield figure("observations_per_vehicle", "1", "observations over vehicles")
    yield figure("observations_per_frame", "1", "observations over frames")
    yield figure("points_per_observation", "1", "points of a graded vehicle in a frame, mean")


def _fit() -> Iterator[MetricDefinition]:
    def of_method(name: str, unit: str, meaning: str, value: str, **other: Any) -> MetricDefinition:
        return MetricDefinition(
            f"fit.{name}", unit, meaning, "fit", value, "{method}", parameters={"method": FIT_METHODS},
            filters=(*OF_VEHICLES, "points"), **other,
        )  # fmt: skip

    degrees, half = (0.0, FIT_HEADING_DEG), (0.0, 0.5 * FIT_HEADING_DEG)
    error = "heading error modulo 90 degrees"
    yield of_method("heading_mean_deg", "deg", f"mean {error}", "heading_error_deg", **_signed(FIT_HEADING_DEG))
    yield of_method(
        "heading_std_deg", "deg", f"STD of the {error}", "heading_error_deg", statistic="std", range=degrees
    )
    yield of_method(
        "heading_abs_mean_deg", "deg", "mean absolute heading error", "heading_abs_error_deg", range=degrees
    )
    yield of_method(
        "heading_abs_std_deg",
        "deg",
        "STD of the absolute heading error",
        "heading_abs_error_deg",
        statistic="std",
        range=half,
    )
    share: dict[str, Any] = {"range": SHARE, "better": "more"}
    yield of_method(
        "rounded_to_0deg", "1", "share of heading errors that are 0 in whole degrees", "rounds_to_0", **share
    )
    for limit in WITHIN_DEG:
        meaning = f"share of heading errors <= {limit} degrees"
        yield of_method(
            f"within_{limit}deg", "1", meaning, f"within_{limit}deg", ranked_by="heading_error_deg", **share
        )
    yield of_method(
        "position_abs_mean_m", "m", "mean distance of the nearest corner to the true one", "position_error_m"
    )
    yield of_method("iou_mean", "1", "mean bird's-eye overlap of rectangle and true box", "iou", **share)
    yield MetricDefinition(
        "fit.coverage", "1", "share of the data set's observations with a fitted rectangle", "traced_vehicle", "fitted",
        "boxed", filters=OF_VEHICLES, interval=False, **share,
    )  # fmt: skip
    yield from _selected_fit()


def _selected_fit() -> Iterator[MetricDefinition]:
    """Yield the metrics of the selected rectangle alone."""

    def of_best(name: str, unit: str, meaning: str, value: str, **other: Any) -> MetricDefinition:
        return MetricDefinition(
            f"fit.{name}", unit, meaning, "fit", value, "best", filters=(*OF_VEHICLES, "points"), **other
        )

    regret = "mean absolute heading error of best minus that of oracle"
    yield of_best("regret_deg", "deg", regret, "regret_deg", range=(0.0, FIT_HEADING_DEG))
    for name, meaning in CORNER_FIGURES.items():
        no_extent: dict[str, Any] = {"why_unknown": "the visible extents are unknown: the grader has no rig"}
        yield of_best(f"{name}_mean_m", "m", f"mean error: {meaning}", f"{name}_error_m", **_signed(), **no_extent)
        yield of_best(f"{name}_abs_mean_m", "m", f"mean absolute error: {meaning}", f"{name}_abs_error_m", **no_extent)
    for percent in COVERAGES:
        yield of_best(
            f"coverage_{percent}", "1",
            f"share of true headings inside the {percent} % interval of the box's heading variance",
            f"inside_{percent}", range=SHARE, better="",
            why_unknown="no fitted rectangle became a box of vehicle size, or an earlier version made the run",
        )  # fmt: skip
    yield of_best(
        "bound_ratio", "1", "mean absolute heading error over that of normal errors at the bound", "bounded_abs_deg",
        weight="at_bound_deg",
        why_unknown="no observation has a bound: range noise or rig are unknown, or no points hold information on the "
        "heading",
    )  # fmt: skip


CORNER_FIGURES = {
    "corner_along": "nearest corner along the vehicle, positive beyond the true box",
    "corner_across": "nearest corner across the vehicle, positive beyond the true box",
    "extent_along": "rectangle's extent minus that of the vehicle's true points, along the vehicle",
    "extent_across": "rectangle's extent minus that of the vehicle's true points, across the vehicle",
}
"""Errors of corner and size with their meanings."""


def _stages() -> Iterator[MetricDefinition]:
    def rate(name: str, meaning: str, kind: str, value: str, rows: str, ranked_by: str) -> MetricDefinition:
        filters = OF_VEHICLES if kind == "traced_vehicle" else ("class", "actor", "time")
        return MetricDefinition(
            f"segmentation.{name}", "1", meaning, kind, value, rows, range=SHARE, filters=filters, interval=False,
            ranked_by=ranked_by,
        )  # fmt: skip

    yield rate(
        "over_rate", "graded vehicles split over two or more segments", "traced_vehicle", "is_split", "segmented",
        "outside_largest_segment_share",
    )  # fmt: skip
    yield rate(
        "under_rate", "segments of graded vehicles merged with another object", "segment", "is_merged", "",
        "second_share",
    )  # fmt: skip
    yield rate(
        "missed_rate", "graded vehicles without a segment with most of their points", "traced_vehicle",
        "has_no_segment", "segmented", "outside_largest_segment_share",
    )  # fmt: skip
    for name, weight, meaning, why in (
        (
            "precision", "removed_or_clean", "removed points of this cause, over these and clean ones",
            "no point was removed in segments with points of this cause",
        ),
        (
            "recall", "points", "points of this cause that were removed",
            "no point of this cause is in a graded vehicle's segment",
        ),
    ):  # fmt: skip
        yield MetricDefinition(
            f"outliers.{name}", "1", meaning, "removal", "removed", "{cause}", weight, "rate", "more", SHARE,
            {"cause": (REQUIRED, *CAUSES.values())}, ("time",), interval=False, why_unknown=why,
        )  # fmt: skip


def _mma() -> Iterator[MetricDefinition]:
    def figure(name: str, unit: str, meaning: str, value: str, **other: Any) -> MetricDefinition:
        return MetricDefinition(f"mma.{name}", unit, meaning, "track", value, filters=OF_VEHICLES, **other)

    model = {"model": ESTIMATES}
    for axis in "xy":
        what = f"absolute error of the tracked corner, ego {axis} axis"
        for name, said, statistic in (("mean", "mean", "mean"), ("std", "STD of the", "std")):
            yield figure(
                f"{axis}_abs_{name}_m", "m", f"{said} {what}", f"{{model}}_{axis}_abs_error_m", rows="{target}",
                statistic=statistic, parameters={**model, "target": ("any", *TARGETS)}, why_none=NO_PAIR,
                why_unknown=NOT_REPORTED,
            )  # fmt: skip
    for label, seconds in HORIZONS.items():
        yield figure(
            f"prediction_{label}_abs_mean_m", "m",
            f"mean distance of the tracked corner from its prediction {seconds:g} s ahead",
            f"{{model}}_ahead_{label}_error_m", rows="{when}", parameters={**model, "when": ("any", "changing")},
            why_none="no confirmed track followed a graded vehicle at such a time",
            why_unknown="the tracker does not report predictions",
        )  # fmt: skip
    yield MetricDefinition(
        "mma.gain", "1", "reduction of the mean distance from the true corner relative to the best single model",
        "gain", statistic="given", better="more", range=(-math.inf, 1.0), parameters={"target": ("any", *TARGETS)},
        filters=OF_VEHICLES, interval=False,
    )  # fmt: skip
    yield from _mode()
    yield from _consistency()


def _mode() -> Iterator[MetricDefinition]:
    def share(name: str, meaning: str, value: str, **other: Any) -> MetricDefinition:
        return MetricDefinition(
            f"mma.{name}", "1", meaning, "track", value, range=SHARE, filters=OF_VEHICLES, why_none=NO_PAIR, **other
        )

    no_model = "the tracker does not report the selected model"
    yield share(
        "mode_accuracy", "share of frames in which the selected model is the true mode", "right_mode", better="more",
        why_unknown=no_model,
    )  # fmt: skip
    yield share(
        "stationary_accuracy", "share of frames with the correct decision on standing or moving", "right_motion",
        better="more", why_unknown="the tracker does not report a model or a velocity",
    )  # fmt: skip
    yield share(
        "selected", "share of the frames with this true mode in which the model is selected", "selected_{model}",
        rows="mode_{mode}", better="", why_unknown=no_model,
        parameters={"mode": (REQUIRED, *MODELS), "model": (REQUIRED, *MODEL_NAMES)},
    )  # fmt: skip
    yield MetricDefinition(
        "mma.switch_latency_frames", "count", "median frames from a true change of mode to its selection", "switch",
        "latency_frames", statistic="median", interval=False, filters=("class", "actor"),
        why_none="no followed vehicle changed its mode",
        why_unknown="half of the changes of mode or more were never selected",
    )  # fmt: skip


def _consistency() -> Iterator[MetricDefinition]:
    for measure, models in (("nees", ESTIMATES), ("nis", (REQUIRED, *MODEL_NAMES))):
        what = f"{measure.upper()} of the tracked corner's position; of a model alone, while it is the true mode"
        figures: tuple[tuple[str, str, tuple[float, float], Better], ...] = (
            ("in_band", f"share inside the two-sided chi-square band, 2 dof, of the {what}", SHARE, "more"),
            ("mean", f"mean, 2 for a consistent filter, of the {what}", POSITIVE, ""),
        )
        for name, meaning, bounds, better in figures:
            yield MetricDefinition(
                f"mma.{measure}_{name}", "1", meaning, "track", f"{{model}}_{measure}_{name}", "describes_{model}",
                better=better, range=bounds, parameters={"model": models}, filters=OF_VEHICLES,
                ranked_by=f"{{model}}_{measure}_mean",
                why_none=NO_PAIR,
                why_unknown=f"the tracker does not report its covariance or the {measure} of its models",
            )  # fmt: skip


NO_VEHICLE = "no vehicle was graded"
NO_TRACK = "no track was reported in the graded range"

SCORES: dict[str, tuple[str, str, Better, tuple[float, float]]] = {
    "hota": ("1", "higher order tracking accuracy", "more", SHARE),
    "deta": ("1", "detection accuracy of HOTA", "more", SHARE),
    "assa": ("1", "association accuracy of HOTA", "more", SHARE),
    "loca": ("1", "localisation accuracy of HOTA: mean overlap of matched pairs", "more", SHARE),
    "mota": ("1", "CLEAR multiple object tracking accuracy", "more", (-math.inf, 1.0)),
    "idf1": ("1", "F1 score of identities", "more", SHARE),
    "id_switches": ("count", "changes of the track that hits a vehicle (CLEAR)", "less", POSITIVE),
    "id_switch_rate": ("1", "id switches over graded vehicles, both summed over frames", "less", SHARE),
    "id_switches_in_view": ("count", "id switches with the vehicle in view all the time", "less", POSITIVE),
    "fragments": ("count", "interruptions of a vehicle's track (CLEAR)", "less", POSITIVE),
    "missed": ("count", "graded vehicles without a track, summed over frames (CLEAR)", "less", POSITIVE),
    "false": ("count", "tracks that hit no vehicle, summed over frames (CLEAR)", "less", POSITIVE),
    "false_on_nothing": ("count", "false tracks that overlap no vehicle", "less", POSITIVE),
    "false_ill_fitting": ("count", "false tracks that overlap a vehicle by less than a hit", "less", POSITIVE),
    "false_duplicate": (
        "count", "false tracks at the position of a vehicle that another track hits", "less", POSITIVE,
    ),
    "false_share": ("1", "false tracks over graded vehicles, both summed over frames", "less", POSITIVE),
}  # fmt: skip
"""Unit, meaning, direction and range of the figures of matched tracks."""

GOSPA = {
    "gospa_m": ("m", "GOSPA of graded vehicles and tracks, mean over frames"),
    "gospa_localisation_m2": ("m^2", "part of squared GOSPA by distances of located vehicles"),
    "gospa_missed_m2": ("m^2", "part of squared GOSPA by missed vehicles"),
    "gospa_false_m2": ("m^2", "part of squared GOSPA by false tracks"),
}


def _track() -> Iterator[MetricDefinition]:
    for name, (unit, meaning, better, bounds) in SCORES.items():
        yield MetricDefinition(
            f"track.{name}", unit, meaning, "score", statistic="given", better=better, range=bounds, filters=OF_VEHICLES
        )
    for name, (unit, meaning) in GOSPA.items():
        yield MetricDefinition(
            f"track.{name}", unit, meaning, "gospa", statistic="given", filters=OF_VEHICLES, interval=False
        )
    yield MetricDefinition(
        "track.motp", "1", "CLEAR multiple object tracking precision: mean overlap of the hits", "vehicle", "hit_iou",
        "is_hit", better="more", range=SHARE, filters=OF_VEHICLES, why_none="no track hits a graded vehicle",
    )  # fmt: skip
    yield from _averages()
    yield from _missed()
    yield from _occlusion()
    yield from _motion()


def _averages() -> Iterator[MetricDefinition]:
    averages: tuple[tuple[str, str, str, Better, tuple[float, float]], ...] = (
        ("amota", "1", "MOTAR of nuScenes, averaged over recalls, then over classes", "more", SHARE),
        (
            "amotp_m",
            "m",
            "distance of the centres of pairs, averaged over recalls, then over classes",
            "less",
            POSITIVE,
        ),
    )
    for name, unit, meaning, better, bounds in averages:
        yield MetricDefinition(
            f"track.{name}", unit, meaning, "recall", statistic="given", better=better, range=bounds,
            filters=("class",), interval=False, needs="score",
        )  # fmt: skip


def _missed() -> Iterator[MetricDefinition]:
    for name, meaning, rows, why in (
        ("missed_share", "graded vehicles without a hit over all, both summed over frames", "", ""),
        (
            "missed_share_standing", "vehicles without a hit over all, of those standing since they came into sight",
            "standing_since_seen", "no graded vehicle stood when it came into sight",
        ),
        (
            "missed_share_long", f"vehicles without a hit over all, of those longer than {LONG_M:g} m", "long",
            f"no graded vehicle was longer than {LONG_M:g} m",
        ),
    ):  # fmt: skip
        yield MetricDefinition(
            f"track.{name}", "1", meaning, "vehicle", "missed", rows, range=SHARE, filters=OF_VEHICLES, why_none=why,
            ranked_by="time_without_hit_s",
        )  # fmt: skip
    censored = "too many vehicles were never confirmed"
    waits: tuple[tuple[str, str, Statistic], ...] = (
        ("time_to_confirm_s", "time from a vehicle's first graded frame to its first hit, median", "order_median"),
        (
            "time_to_confirm_p90_s",
            "time from a vehicle's first graded frame to its first hit, 90th percentile",
            "order_p90",
        ),
    )
    for name, meaning, statistic in waits:
        yield MetricDefinition(
            f"track.{name}", "s", meaning, "confirmation", "wait_s", statistic=statistic, filters=OF_VEHICLES,
            interval=False, why_unknown=censored,
        )  # fmt: skip
    yield MetricDefinition(
        "track.never_confirmed", "1", "share of graded vehicles that no track ever hits", "confirmation", "never",
        range=SHARE, filters=OF_VEHICLES,
    )  # fmt: skip


def _occlusion() -> Iterator[MetricDefinition]:
    never = "no followed vehicle was hidden and came back within {}"
    for name, meaning, rows, longest in (
        ("occlusion_survival", "occlusions of graded vehicles survived by the track's id", "", "grading.memory_s"),
        (
            "hidden_2s_survival", f"occlusions of at most {SHORT_OCCLUSION_S:g} s survived by the track's id", "short",
            f"{SHORT_OCCLUSION_S:g} s",
        ),
    ):  # fmt: skip
        yield MetricDefinition(
            f"track.{name}", "1", meaning, "occlusion", "survived", rows, better="more", range=SHARE,
            filters=("class", "actor", "time"), interval=False, why_none=never.format(longest),
        )  # fmt: skip
    again = "no followed vehicle was hidden, came back and was followed again"
    for name, unit, meaning, value in (
        ("reacquire_s", "s", "mean time until a track follows an occluded vehicle again", "reacquired_s"),
        ("reappearance_error_m", "m", "mean error of that track's centre at this time", "position_error_m"),
    ):
        yield MetricDefinition(
            f"track.{name}", unit, meaning, "occlusion", value, filters=("class", "actor", "time"), interval=False,
            why_none=again,
        )  # fmt: skip


def _motion() -> Iterator[MetricDefinition]:
    unknown = "the tracker does not report this estimate, or an earlier version made the run"

    def figure(name: str, unit: str, meaning: str, value: str, rows: str = "", **other: Any) -> MetricDefinition:
        why = f"{NO_PAIR} that was {rows}" if rows else NO_PAIR
        return MetricDefinition(
            f"track.{name}", unit, meaning, "track", value, rows, filters=OF_VEHICLES, why_none=why,
            why_unknown=unknown, **other,
        )  # fmt: skip

    turn = (0.0, TRACK_HEADING_DEG)
    yield figure("position_abs_mean_m", "m", "mean distance of the centres of track and vehicle", "position_error_m")
    yield figure("iou_mean", "1", "mean bird's-eye overlap of track and vehicle", "iou", better="more", range=SHARE)
    yield figure(
        "orientation_abs_mean_deg", "deg", "mean absolute heading error modulo 360, moving and standing vehicles",
        "heading_abs_error_deg", range=turn,
    )  # fmt: skip
    heading = "absolute heading error modulo 360, moving vehicles"
    yield figure("heading_abs_mean_deg", "deg", f"mean {heading}", "heading_abs_error_deg", "moving", range=turn)
    yield figure(
        "heading_abs_p90_deg", "deg", f"90th percentile of the {heading}", "heading_abs_error_deg", "moving",
        range=turn, statistic="p90", interval=False,
    )  # fmt: skip
    yield figure(
        "heading_flip_rate", "1", "headings more than 90 degrees off, moving vehicles", "flipped", "moving",
        range=SHARE, ranked_by="heading_error_deg",
    )  # fmt: skip
    yield figure(
        "heading_unflipped_mean_deg", "deg", "mean absolute heading error of headings that are not flipped",
        "unflipped_heading_abs_error_deg", "moving", range=(0.0, 90.0),
    )  # fmt: skip
    yield figure(
        "standing_heading_abs_mean_deg", "deg", "mean absolute heading error modulo 180, standing vehicles",
        "heading_axis_abs_error_deg", "standing", range=(0.0, 0.5 * TRACK_HEADING_DEG),
    )  # fmt: skip
    yield figure(
        "standing_flip_rate", "1", "headings more than 90 degrees off, standing vehicles", "flipped", "standing",
        range=SHARE, ranked_by="heading_error_deg",
    )  # fmt: skip
    for which, meaning in (
        ("stopped", "standing vehicles that moved in sight before"),
        ("parked", "vehicles standing since they came into sight"),
    ):
        yield figure(
            f"{which}_flip_rate", "1", f"headings more than 90 degrees off, {meaning}", "flipped", which,
            range=SHARE, ranked_by="heading_error_deg",
        )  # fmt: skip
    yield figure("velocity_abs_mean_mps", "m/s", "mean norm of the velocity error", "velocity_error_mps")
    yield figure(
        "moving_velocity_abs_mean_mps",
        "m/s",
        "mean norm of the velocity error, moving vehicles",
        "velocity_error_mps",
        "moving",
    )
    yield figure("standing_speed_mean_mps", "m/s", "mean speed of tracks on standing vehicles", "speed_mps", "standing")
    yield figure("speed_abs_mean_mps", "m/s", "mean absolute error of the speed", "speed_abs_error_mps")
    yield figure("speed_mean_mps", "m/s", "mean error of the speed", "speed_error_mps", **_signed())
    yield figure(
        "acceleration_abs_mean_mps2", "m/s^2", "mean norm of the acceleration error, moving vehicles",
        "acceleration_error_mps2", "moving",
    )  # fmt: skip
    for size in ("length", "width"):
        yield figure(f"{size}_mean_m", "m", f"mean error of the {size}", f"{size}_error_m", **_signed())
        yield figure(f"{size}_abs_mean_m", "m", f"mean absolute error of the {size}", f"{size}_abs_error_m")
    yield figure(
        "height_abs_mean_m", "m", "mean absolute error of the height", "height_abs_error_m", needs="height_error_m"
    )


MEASURES: dict[str, tuple[str, str, Better]] = {
    "time_s": ("s", "time since the start of the run", "less"),
    "delay_s": ("s", "time since the first beam", "less"),
    "range_m": ("m", "distance of the centres of ego and actor", "more"),
    "ttc_s": ("s", "time to collision of the boxes at constant velocities", "more"),
    "meeting_m": ("m", "distance of the ego's front from the meeting point, along its path", "more"),
    "meeting_s": ("s", "time until the ego's front is at the meeting point", "more"),
    "reached": ("1", "1 if the stage is reached; of a group, the share of the actors that a beam hit", "more"),
}
"""Unit, meaning and direction of each measure of emergence."""
OF_GROUPS = ("delay_s", "range_m", "reached")
"""Measures of a group: medians (of the delay by Kaplan and Meier), and the share."""
SURVIVAL = {"time_s": False, "delay_s": False, "meeting_m": True, "meeting_s": True}
"""Measures that only grow (False) or only fall (True) in a run: those that a survival curve may be drawn over."""


def _emergence() -> Iterator[MetricDefinition]:
    for name, (unit, meaning, better) in MEASURES.items():
        stages = (*STAGES, END) if name in SURVIVAL else tuple(STAGES)
        group = {"group": tuple(EMERGING)} if name in OF_GROUPS else {}
        bounds = SHARE if name == "reached" else ANY if name.startswith(("ttc", "meeting")) else POSITIVE
        yield MetricDefinition(
            f"emergence.{name}", unit, f"{meaning}; at the stage", "emergence", statistic="given",
            better=better, range=bounds,
            parameters={"stage": (REQUIRED, *stages), **group},
        )  # fmt: skip


def survival_measure(name: str) -> tuple[str, str] | None:
    """Return stage and measure of a metric of the target that a survival curve can show, or None."""
    chosen = find_metric(name)
    measure, stage = chosen.definition.name.removeprefix("emergence."), chosen.parameters.get("stage", "")
    of_target = chosen.parameters.get("group", "target") == "target"
    return (stage, measure) if of_target and stage in STAGES and measure in SURVIVAL else None


EVENT_COUNTS = {
    "ego_collisions": "overlaps of an actor's body with the ego's, and collisions by which SUMO moves one of both",
    "overlaps": "overlaps of the bodies of two actors",
    "teleports": "road users that continue at a place that their velocity does not lead to",
    "insertions_in_view": "actors that appear in view of the LIDARs, in the graded range",
    "removals_in_view": "actors that vanish in view of the LIDARs, in the graded range",
    "id_changes": "actors that vanish and continue in their place with another id",
    "limit_violations": "bodies that exceed a limit of vehicle dynamics",
    "masked_observations": "observations of vehicles that are not graded because of such events",
}
EVENT_EXTREMES = {
    "overlap_max_m2": ("m^2", "largest overlap of two bodies, the ego's included; 0 without one"),
    "acceleration_max_mps2": ("m/s^2", "largest acceleration of any body, along and across"),
    "jerk_max_mps3": ("m/s^3", "largest change of acceleration between two frames, over the time between them"),
}


def _events() -> Iterator[MetricDefinition]:
    for name, meaning in EVENT_COUNTS.items():
        yield MetricDefinition(f"sim.{name}", "count", meaning, "event", statistic="given")
    for name, (unit, meaning) in EVENT_EXTREMES.items():
        yield MetricDefinition(f"sim.{name}", unit, meaning, "event", statistic="given")


VULNERABLE_SCORES = {
    "hota": "higher order tracking accuracy, with similarity 1 - distance / match_distance_m",
    "deta": "detection accuracy of HOTA",
    "assa": "association accuracy of HOTA",
    "mota": "CLEAR multiple object tracking accuracy; a hit is within half of match_distance_m",
    "idf1": "F1 score of identities",
}
VULNERABLE_COUNTS = {
    "id_switches": "changes of the track that hits one of them (CLEAR)",
    "fragments": "interruptions of a track (CLEAR)",
    "missed": "graded ones without a hit, summed over frames (CLEAR)",
    "false": "tracks of small road users that hit none, summed over frames (CLEAR)",
}


def _vulnerable(group: str) -> Iterator[MetricDefinition]:
    def figure(name: str, unit: str, meaning: str, **other: Any) -> MetricDefinition:
        return MetricDefinition(f"{group}.{name}", unit, f"{group}: {meaning}", group, statistic="given", **other)

    yield figure("observations", "count", "graded ones, summed over frames", better="")
    for name, meaning in VULNERABLE_SCORES.items():
        bounds = SCORES[name][3]
        yield figure(name, "1", meaning, better="more", range=bounds)
    for name, meaning in VULNERABLE_COUNTS.items():
        yield figure(name, "count", meaning)
    yield figure(
        "missed_share", "1", "without a hit over all, both summed over frames", range=SHARE, filters=("range",)
    )
    yield figure("called_vehicle_share", "1", "followed by a track of a vehicle, over all of them", range=SHARE)
    yield figure("position_abs_mean_m", "m", "mean distance of the centres of hits")
    yield figure("velocity_abs_mean_mps", "m/s", "mean norm of the velocity error of hits")
    yield figure("speed_abs_mean_mps", "m/s", "mean absolute error of the speed of hits")
    yield figure("time_to_confirm_s", "s", "time from the first graded frame to the first hit, median")
    yield figure("never_confirmed", "1", "share of the graded ones that no track ever hits", range=SHARE)


SAFETY: dict[str, tuple[str, str, Better, tuple[float, float]]] = {
    "min_ttc_s": ("s", "least true time to collision with an actor in the ego's path", "more", ANY),
    "min_gap_m": ("m", "least true gap to an actor in the ego's path", "more", ANY),
    "max_deceleration_mps2": ("m/s^2", "largest true deceleration of the ego", "less", POSITIVE),
    "collisions": ("count", "actors that the ego collided with", "less", POSITIVE),
}
"""Unit, meaning, direction and range of the safety metrics of each drive of a controlled ego."""


def _control() -> Iterator[MetricDefinition]:
    for (driver, prefix), (name, (unit, meaning, better, bounds)) in product(DRIVERS.items(), SAFETY.items()):
        yield MetricDefinition(
            f"control.{prefix}{name}", unit, f"{meaning}, controlled by the {driver}", "control", statistic="given",
            better=better, range=bounds,
        )  # fmt: skip


def _performance() -> Iterator[MetricDefinition]:
    for stage, quantile in product(TIMED_STAGES, ("p50", "p99")):
        meaning = f"time per frame in the {stage}, {quantile}"
        yield MetricDefinition(f"perf.{stage}_ms_{quantile}", "ms", meaning, "performance", statistic="given")
    meaning = "simulated time over wall-clock time of the whole loop"
    yield MetricDefinition("perf.realtime_factor", "1", meaning, "performance", statistic="given", better="more")


DEFINITIONS: dict[str, MetricDefinition] = {
    one.name: one
    for one in (
        *(*_dataset(), *_fit(), *_stages(), *_mma(), *_track(), *_emergence(), *_events()),
        *(definition for group in GROUPS for definition in _vulnerable(group)),
        *(*_control(), *_performance()),
    )
}
"""All metrics by name."""

OF_LOOP = ("control", "performance")
"""Kinds of the metrics that the run loop measures; grading has all others."""


@cache
def find_metric(name: str) -> Selection:
    """Return the metric of a name with its parameters and filters.

    Raises
    ------
    ValueError
        There is no such metric, or it has no such parameter or filter. The message names close or later names.
    """
    base, brace, inside = name.partition("{")
    definition = DEFINITIONS.get(base)
    if definition is None or (brace and not inside.endswith("}")):
        later = present_name(name)
        if later.partition("{")[0] in DEFINITIONS:
            raise ValueError(f"is named {later} now")
        close = get_close_matches(later.partition("{")[0] or base, DEFINITIONS, n=3, cutoff=0.5)
        hint = f"did you mean {', '.join(close)}?" if close else "luxloop metrics lists all names"
        raise ValueError(f"unknown metric; {hint}")
    return select(definition, inside.removesuffix("}"))


def is_metric(name: str) -> bool:
    """Return True for the name of a metric, with any parameters and filters."""
    try:
        find_metric(name)
    except ValueError:
        return False
    return True


@cache
def standard_names() -> tuple[str, ...]:
    """Return the names of the figures that every result holds: each metric, with all values of required parameters."""
    names = []
    for definition in DEFINITIONS.values():
        required = {key: values[1:] for key, values in definition.parameters.items() if values[0] == REQUIRED}
        if "group" in definition.parameters:
            required["group"] = definition.parameters["group"]
        for chosen in product(*required.values()):
            if END in chosen and chosen[-1] in [*EMERGING][1:]:
                continue  # only the target has an end of observation
            given = ",".join(f"{key}={value}" for key, value in zip(required, chosen, strict=True))
            names.append(select(definition, given).name)
    return tuple(names)
