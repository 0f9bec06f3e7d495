"""Tables of a run: fits, filters, tracks, people, emergence, metrics of the scenario and speed."""

from collections.abc import Iterable, Mapping
from typing import Any

from luxloop.scenarios.document.document import Paragraph, Style, Table
from luxloop.scenarios.metrics.definition import filtered
from luxloop.scenarios.metrics.definitions import (
    CAUSES,
    CORNER_FIGURES,
    COVERAGES,
    DRIVERS,
    FIT_METHODS,
    GROUPS,
    HORIZONS,
    POINT_BANDS,
    RANGE_BANDS,
    REPORTED_BANDS,
    SAFETY,
    STAGES,
    TIMED_STAGES,
    VIEWS,
    VULNERABLE_COUNTS,
    VULNERABLE_SCORES,
    estimates,
    find_metric,
)
from luxloop.scenarios.metrics.own_metric import OwnMetric
from luxloop.scenarios.report.cells import interval_of, percent_of, table_of, unit_of, value_of
from luxloop.scenarios.result import Metric, Result
from luxloop.tracker.records import BASELINES, MODELS


def modes(result: Result) -> Table:
    """Return the confusion table of the selected model by true mode."""
    models = result.metrics.run.models
    table = table_of("Selected model by true mode", "true mode", *models, "n")
    for mode in MODELS:
        rates = [result.metrics[f"mma.selected{{mode={mode},model={model}}}"] for model in models]
        table.add_row(mode, *map(percent_of, rates), str(rates[0].n))
    return table


def predictions(result: Result) -> Table:
    """Return the errors of predicted positions, overall and around changes of the true mode."""
    title = "Mean distance of the tracked corner from its prediction [m]; changes: within 1 s of a change of mode"
    labels = [f"{seconds:g} s{where}" for where in ("", ", changes") for seconds in HORIZONS.values()]
    table = table_of(title, "model", *labels, "n")
    for estimate in estimates(result.metrics.run.models):
        found = [
            result.metrics[filtered(f"mma.prediction_{label}_abs_mean_m", model=estimate, when=when)]
            for when in ("any", "changing")
            for label in HORIZONS
        ]
        table.add_row(estimate, *map(value_of, found), str(found[0].n), style="bold" if estimate == "mma" else "")
    return table


def consistency(result: Result) -> Table:
    """Return a table of NEES and NIS of the filters."""
    title = "Consistency of the filters, each while it is the true mode: share in the chi-square band, mean (2)"
    table = table_of(title, "model", "NEES in band", "NEES mean", "NIS in band", "NIS mean", "n")
    for model in result.metrics.run.models:
        nees, nees_mean, nis, nis_mean = (
            result.metrics[f"mma.{name}_{what}{{model={model}}}"]
            for name in ("nees", "nis")
            for what in ("in_band", "mean")
        )
        cells = [percent_of(nees), value_of(nees_mean), percent_of(nis), value_of(nis_mean), str(nees.n)]
        table.add_row(model, *cells)
    nees, mean = result.metrics["mma.nees_in_band"], result.metrics["mma.nees_mean"]
    table.add_row("mma, always", percent_of(nees), value_of(mean), "", "", str(nees.n), style="bold")
    return table


def outliers(result: Result) -> Table:
    """Return precision and recall of outlier removal by cause."""
    table = table_of("Outlier removal by cause of the outlier", "cause", "precision", "recall", "points")
    for cause in CAUSES.values():
        precision, recall = (result.metrics[f"outliers.{name}{{cause={cause}}}"] for name in ("precision", "recall"))
        table.add_row(cause.replace("_", " "), value_of(precision), value_of(recall), str(recall.n))
    return table


def metric_list(title: str, result: Result, prefixes: tuple[str, ...]) -> Table:
    """Return a table with a row for each metric with one of the prefixes."""
    return metric_rows(title, result, [name for name in result.metrics if name.startswith(prefixes)])


def metric_rows(title: str, result: Result, names: Iterable[str]) -> Table:
    """Return a table with a row for each metric of a run: its value, 95 % interval and meaning."""
    return figure_rows(title, result.metrics, names)


def figure_rows(title: str, metrics: Mapping[str, Metric], names: Iterable[str]) -> Table:
    """Return a table with a row for each of these metrics: its value, 95 % interval and meaning."""
    table = table_of(title, "metric", "value", "95 %", "n")
    table.add_column("", style="dim")
    for name in names:
        metric = metrics[name]
        meaning = metric.reason or find_metric(name).meaning
        table.add_row(name, value_of(metric), interval_of(metric), str(metric.n), meaning)
    return table


def control(result: Result) -> Table:
    """Return the safety metrics of the controlled ego, driven by the tracks and by the truth."""
    table = table_of("Controlled ego, by the truth of its drives", "", *(f"by the {driver}" for driver in DRIVERS))
    for name, (unit, meaning, *_) in SAFETY.items():
        metrics = [result.metrics[f"control.{prefix}{name}"] for prefix in DRIVERS.values()]
        table.add_row(f"{meaning} [{unit}]", *map(value_of, metrics))
    return table


def speed(result: Result) -> Table:
    """Return the time per frame and stage, and the real-time factor of the whole loop."""
    table = table_of("Time per frame [ms]", "stage", "median", "99 %")
    for stage in TIMED_STAGES:
        quantiles = [result.metrics[f"perf.{stage}_ms_{quantile}"] for quantile in ("p50", "p99")]
        table.add_row(stage, *map(value_of, quantiles), end_section=stage == TIMED_STAGES[-1])
    factor = result.metrics["perf.realtime_factor"].value
    if factor is not None:
        table.add_row("whole loop", f"{factor:.1f} x real time", "without recording")
    return table


def grading_limits(limits: Mapping[str, Any]) -> Paragraph:
    """Return the limits of grading, which the metrics depend on; those that are no numbers are left out."""
    numbers = {name: value for name, value in limits.items() if isinstance(value, int | float)}
    return Paragraph("Graded with " + ", ".join(f"{name} = {value:g}" for name, value in numbers.items()), "dim")


SCOPES = {"all": "", **{view.replace("_", "-"): view for view in VIEWS.values()}}
"""Views by their names in the tables; all without one."""
FIT_BANDS = {
    **{f"{band} m": {"range": band} for band in RANGE_BANDS},
    **{f"{band} points": {"points": band} for band in POINT_BANDS},
}
"""Filters by their names in the tables."""


def of_method(figure: str, method: str, **filters: str) -> str:
    """Return the name of a figure of a method's rectangles."""
    return filtered(f"fit.{figure}", method="" if method == FIT_METHODS[0] else method, **filters)


def methods_of(result: Result) -> list[str]:
    """Return the methods with fits: all except disabled baselines."""
    return [m for m in FIT_METHODS if m not in BASELINES or result.metrics[of_method("heading_mean_deg", m)].n]


def emphasis(method: str) -> Style:
    """Return the style of a method's row."""
    return "bold" if method == "best" else "dim" if method == "oracle" else ""


def heading_by_band(result: Result) -> Table:
    """Return mean absolute heading errors by range and by number of points."""
    title = "Mean absolute fit heading error by range and by points of the segment [deg]"
    table = table_of(title, "method", *(name.replace("points", "pts") for name in FIT_BANDS))
    for method in methods_of(result):
        metrics = [result.metrics[of_method("heading_abs_mean_deg", method, **band)] for band in FIT_BANDS.values()]
        table.add_row(method, *map(value_of, metrics), style=emphasis(method))
    counts = [str(result.metrics[filtered("fit.heading_abs_mean_deg", **band)].n) for band in FIT_BANDS.values()]
    table.add_row("n", *counts, style="dim")
    return table


def selection(result: Result) -> Table:
    """Return the regret of the selection, the coverage of the headings' intervals, and the ratio to the bound."""
    columns = (*(f"in {percent} %" for percent in COVERAGES), "over bound", "n")
    table = table_of(
        "Selected fits: regret of the fit heading [deg], true headings inside its intervals",
        "",
        "regret",
        "95 %",
        *columns,
    )
    for name, scope in SCOPES.items():
        regret, ratio, *coverage = (
            result.metrics[filtered(f"fit.{figure}", view=scope)]
            for figure in ("regret_deg", "bound_ratio", *(f"coverage_{percent}" for percent in COVERAGES))
        )
        cells = [value_of(regret), interval_of(regret), *map(percent_of, coverage), value_of(ratio), str(regret.n)]
        table.add_row(name, *cells)
    for name, band in FIT_BANDS.items():
        regret = result.metrics[filtered("fit.regret_deg", **band)]
        blank = [""] * (len(COVERAGES) + 1)
        table.add_row(name, value_of(regret), interval_of(regret), *blank, str(regret.n))
    return table


def corner_and_extents(result: Result) -> Table:
    """Return means and mean absolute values of the errors of the nearest corner and of the visible extents."""
    heads = [head for name in CORNER_FIGURES for head in (name.replace("_", "\n"), "\n|e|")]
    table = table_of("Selected fits: nearest corner (+ is outside) and visible extents, means [m]", "", *heads, "n")
    for name, scope in SCOPES.items():
        metrics = [
            result.metrics[filtered(f"fit.{figure}_{kind}_m", view=scope)]
            for figure in CORNER_FIGURES
            for kind in ("mean", "abs_mean")
        ]
        table.add_row(name, *map(value_of, metrics), str(metrics[0].n))
    return table


TRACK_TABLES: dict[str, tuple[str, ...]] = {
    "Tracking": (
        *("hota", "deta", "assa", "loca", "mota", "motp", "idf1"),
        *("id_switches", "id_switch_rate", "id_switches_in_view", "fragments", "missed", "false"),
        *("occlusion_survival", "hidden_2s_survival", "reacquire_s", "reappearance_error_m"),
    ),
    "Found and missed vehicles, false tracks": (
        *("time_to_confirm_s", "time_to_confirm_p90_s", "never_confirmed"),
        *("missed_share", "missed_share_standing", "missed_share_long"),
        *("false_on_nothing", "false_ill_fitting", "false_duplicate", "false_share"),
        *("gospa_m", "gospa_localisation_m2", "gospa_missed_m2", "gospa_false_m2"),
    ),
    "Motion, track heading and size": (
        *("position_abs_mean_m", "iou_mean", "orientation_abs_mean_deg"),
        *("velocity_abs_mean_mps", "moving_velocity_abs_mean_mps", "standing_speed_mean_mps", "speed_abs_mean_mps"),
        *("speed_mean_mps", "acceleration_abs_mean_mps2"),
        *("heading_abs_mean_deg", "heading_abs_p90_deg", "heading_flip_rate", "heading_unflipped_mean_deg"),
        *("standing_heading_abs_mean_deg", "standing_flip_rate", "stopped_flip_rate", "parked_flip_rate"),
        *("length_mean_m", "length_abs_mean_m", "width_mean_m", "width_abs_mean_m"),
    ),
}
"""Metrics of tracks by the titles of their tables."""

BANDED_TABLES = {
    "Missed vehicles and sizes by range, class and view": {
        "track.missed_share": "missed",
        "track.time_to_confirm_s": "confirm [s]",
        "track.gospa_m": "GOSPA [m]",
        "track.length_mean_m": "length [m]",
        "track.length_abs_mean_m": "|e|",
        "track.width_mean_m": "width [m]",
        "track.width_abs_mean_m": "|e|",
    },
    "Motion and track heading by range, class and view [m/s, m/s^2, deg]": {
        "track.moving_velocity_abs_mean_mps": "velocity",
        "track.standing_speed_mean_mps": "standing",
        "track.acceleration_abs_mean_mps2": "acceleration",
        "track.heading_abs_mean_deg": "track heading",
        "track.heading_flip_rate": "flips",
    },
}
"""Titles of the columns by banded metric, for each table by its title."""


def tracking(result: Result) -> list[Table]:
    """Return a table for each group of track metrics of the whole run, and one of those that no group has."""
    groups = {title: [f"track.{name}" for name in names] for title, names in TRACK_TABLES.items()}
    listed = {name for names in groups.values() for name in names}
    others = [name for name in result.metrics if name.startswith("track.") and "{" not in name and name not in listed]
    return [metric_rows(title, result, names) for title, names in [*groups.items(), ("Others", others)] if names]


def tracks_by_band(result: Result) -> list[Table]:
    """Return tables of the banded metrics by range, class and view, with the observations of the first of them."""
    return [_by_band(title, columns, result) for title, columns in BANDED_TABLES.items()]


def _by_band(title: str, columns: Mapping[str, str], result: Result) -> Table:
    table = table_of(title, "", *columns.values(), "n")
    for band in REPORTED_BANDS:
        metrics = [result.metrics[filtered(name, **band)] for name in columns]
        table.add_row(band_label(band), *map(value_of, metrics), str(metrics[0].n))
    return table


def band_label(band: Mapping[str, str]) -> str:
    """Return the text of a filter: `range 0-15 m`, `class bus`, `view l shape`."""
    ((key, value),) = band.items()
    return f"{key} {value} m" if key == "range" else f"{key} {value.replace('_', ' ')}"


VULNERABLE_ERRORS = {
    "missed_share": "missed, share",
    "called_vehicle_share": "called a vehicle, share",
    "position_abs_mean_m": "position |e| [m]",
    "velocity_abs_mean_mps": "velocity |e| [m/s]",
    "speed_abs_mean_mps": "speed |e| [m/s]",
    "time_to_confirm_s": "time to confirm, median [s]",
    "never_confirmed": "never confirmed, share",
}
"""Titles of the rows of errors by the names of metrics."""


def vulnerable(result: Result) -> list[Table]:
    """Return a table of people and riders; none for a run without them."""
    if not any(_observations(result, group) for group in GROUPS):
        return []
    table = table_of("People and riders", "metric", *GROUPS)
    scores = {name: name.replace("_", " ") for name in (*VULNERABLE_SCORES, *VULNERABLE_COUNTS)}
    rows = {"observations": "observations"} | scores | VULNERABLE_ERRORS
    for name, title in rows.items():
        metrics = [result.metrics[f"{group}.{name}"] for group in GROUPS]
        table.add_row(title, *map(value_of, metrics))
    return [table]


def _observations(result: Result, group: str) -> float:
    metric = result.metrics.get(f"{group}.observations")
    return (metric.value if metric else None) or 0.0


EMERGENCE_HEADS = {
    "time_s": "time [s]",
    "delay_s": "since beam [s]",
    "range_m": "range [m]",
    "ttc_s": "collision in [s]",
    "meeting_m": "meeting in [m]",
    "meeting_s": "[s]",
}
"""Title of the column of each measure."""


def emergence(result: Result) -> list[Table]:
    """Return a table with the moments of the target's emergence; none without `grading.target`."""
    target = result.config["grading"].get("target", "")
    if not target:
        return []
    table = table_of(f"Emergence of {target}", "", *EMERGENCE_HEADS.values())
    for stage in STAGES:
        metrics = [result.metrics[f"emergence.{name}{{stage={stage}}}"] for name in EMERGENCE_HEADS]
        table.add_row(stage.replace("_", " "), *(value_of(metric, 2) for metric in metrics))
    return [table]


def own_metrics(result: Result) -> list[Table]:
    """Return a table with a row for each `[[metric]]`: value with unit, 95 % interval and meaning; none without any."""
    defined = [OwnMetric.model_validate(metric) for metric in result.config.get("metric", [])]
    if not defined:
        return []
    table = table_of("Metrics of the scenario", "metric", "value", "95 %", "n")
    table.add_column("", style="dim")
    for one in defined:
        metric = result.metrics[one.name]
        unit = "" if metric.value is None else unit_of(metric)
        meaning = metric.reason or one.definition.meaning
        table.add_row(one.name, f"{value_of(metric)}{unit}", interval_of(metric), str(metric.n), meaning)
    return [table]
