"""The paper's tables I to IV with its own figures beside those of runs, and whether they are reproduced.

The paper's figures were measured on its own recordings with hand-labelled truth: "Low-cost LIDAR based
Vehicle Pose Estimation and Tracking", tables I to IV.
"""

import math
from collections.abc import Callable, Iterable, Mapping
from itertools import product

from luxloop.scenarios.document.document import Table
from luxloop.scenarios.grading.figures import Figures
from luxloop.scenarios.metrics.definition import filtered
from luxloop.scenarios.metrics.definitions import NO_VIEW, TARGETS, VIEWS, estimates
from luxloop.scenarios.report.cells import NONE, interval_of, percent_of, table_of, value_of
from luxloop.scenarios.report.run_tables import emphasis, methods_of, of_method
from luxloop.scenarios.result import Metric, Result

DATASET = {
    "vehicles": 60,
    "observations": 5353,
    "frames": 1368,
    "observations_per_vehicle": 89,
    "observations_per_frame": 4,
}
"""Table I without the views. A "tracker" of the table is a vehicle tracked from its first to its last appearance."""

PAPER_VIEWS = {"l_shape": 5037, "side": 115, "rear": 201}
"""Table I: observations by view of the vehicle."""

HEADING_DEG = {
    "area": (0.6483, 14.7989),
    "closeness": (0.0069, 3.6467),
    "variance": (-0.1517, 2.1869),
    "tlinkage": (0.3586, 2.3204),
    "best": (-0.223, None),
}
"""Table II: mean and STD of the heading error by method [deg]. The last STD is printed as -0.248, which is invalid."""

HEADING_ABS_DEG = {
    "area": (12.3310, 8.1437),
    "closeness": (2.0069, 3.0402),
    "variance": (1.4759, 1.6162),
    "tlinkage": (1.5586, 1.7515),
    "best": (1.3517, 1.2147),
}
"""Table II: mean and STD of the absolute heading error by method [deg]."""

WITHIN = {
    "variance": (0.607, 0.834, 0.910, 0.959, 0.972),
    "best": (0.600, 0.869, 0.965, 0.965, 0.993),
}
"""Table III: share of absolute heading errors of at most 1, 2, 3, 4 and 5 degrees."""

ZERO = {"variance": 0.221, "best": 0.234}
"""Table III: share of errors "= 0". A continuous error is never 0: headings were rounded, apparently to whole degrees.
Errors with a Laplace distribution of the mean of table II (variance), rounded, give 29, 64, 82, 91, 95 and 98 % in the
columns of table III, where the paper has 22, 61, 83, 91, 96 and 97 %; without rounding 0, 49, 74, 87, 93 and 97 %."""

POSITION_ABS_M = {
    ("single", "standing"): (0.1263, 0.0602, 0.1428, 0.0571),
    ("MMA", "standing"): (0.1239, 0.0570, 0.1376, 0.0544),
    ("single", "moving"): (0.2449, 0.1725, 0.1918, 0.1188),
    ("MMA", "moving"): (0.2384, 0.1397, 0.1626, 0.1201),
}
"""Table IV: x mean, x STD, y mean, y STD of the absolute position error by method and targets [m]."""


def dataset(result: Result) -> Table:
    """Return table I: the data set."""
    table = table_of("Data set", "category", "count", "share")
    for name in ("vehicles", "observations", "frames", "observations_per_vehicle", "observations_per_frame"):
        table.add_row(name.replace("_", " "), value_of(result.metrics[f"dataset.{name}"], digits=1), "")
    for view in (*VIEWS.values(), NO_VIEW):
        count, share = (result.metrics[f"dataset.{name}{{view={view}}}"] for name in ("observations", "share"))
        table.add_row(f"view: {view.replace('_', '-')}", value_of(count), percent_of(share))
    return table


def heading_error(result: Result) -> Table:
    """Return table II: heading errors by method, with the intervals of the mean absolute errors."""
    columns = ("mean", "STD", "mean |e|", "95 %", "STD |e|", "n")
    table = table_of("Fit heading error by method, modulo 90 degrees [deg]", "method", *columns)
    for method in methods_of(result):
        metrics = [
            result.metrics[of_method(f"heading_{name}_deg", method)] for name in ("mean", "std", "abs_mean", "abs_std")
        ]
        mean, std, abs_mean, abs_std = map(value_of, metrics)
        interval, n = interval_of(metrics[2]), str(metrics[0].n)
        table.add_row(method, mean, std, abs_mean, interval, abs_std, n, style=emphasis(method))
    return table


def heading_distribution(result: Result) -> Table:
    """Return table III: the distribution of heading errors, with the interval of each share.

    Its column "= 0", as in the paper, has errors below 0.5.
    """
    title = "Share of fit heading errors of at most, with its 95 % interval; = 0 in whole degrees"
    table = table_of(title, "method", "= 0", *(f"{limit} deg" for limit in range(1, 6)))
    for method in methods_of(result):
        zero = percent_of(result.metrics[of_method("rounded_to_0deg", method)])
        shares = [result.metrics[of_method(f"within_{limit}deg", method)] for limit in range(1, 6)]
        cells = [f"{percent_of(share)} {_spread(share)}".rstrip() for share in shares]
        table.add_row(method, zero, *cells, style=emphasis(method))
    return table


def heading_by_view(result: Result) -> Table:
    """Return heading errors by view of the vehicle."""
    counts = {view: result.metrics[f"fit.heading_abs_mean_deg{{view={view}}}"].n for view in VIEWS.values()}
    columns = (f"{view.replace('_', '-')}, n = {count}" for view, count in counts.items())
    table = table_of("Mean absolute fit heading error by view [deg]", "method", *columns)
    for method in methods_of(result):
        metrics = [result.metrics[of_method("heading_abs_mean_deg", method, view=view)] for view in counts]
        table.add_row(method, *map(value_of, metrics), style=emphasis(method))
    return table


def position_error(result: Result) -> Table:
    """Return table IV: position errors of every model."""
    columns = ("targets", "x mean", "95 %", "x STD", "y mean", "95 %", "y STD", "n")
    table = table_of("Absolute error of the tracked corner, on the ego's axes [m]", "model", *columns)
    for target, estimate in product(TARGETS, estimates(result.metrics.run.models)):
        cells = []
        for axis in "xy":
            mean, std = (
                result.metrics[filtered(f"mma.{axis}_abs_{figure}_m", model=estimate, target=target)]
                for figure in ("mean", "std")
            )
            cells += [value_of(mean), interval_of(mean).removesuffix(" vehicles"), value_of(std)]  # two on a line
        table.add_row(estimate, target, *cells, str(mean.n), style="bold" if estimate == "mma" else "")
    return table


def _spread(share: Metric) -> str:
    """Format the interval of a share in percent; empty without one or with equal ends: other columns need room."""
    if share.interval is None:
        return ""
    shown = interval_of(share, percent=True)
    low, _, high = shown.partition("-")
    return shown if low != high else ""


Sources = Mapping[str, Figures]
"""Metrics of runs by the titles of their columns; at least one."""
TOLERANCE = 0.25
"""Largest deviation of a figure that is reproduced, as a share of the paper's."""
BEST, MMA = "best", "mma"


def data_set(sources: Sources) -> Table:
    """Return table I: the data set."""
    table = _table("Table I: data set", "category", sources)
    for name, published in DATASET.items():
        shown = [value_of(figures[f"dataset.{name}"], digits=1) for figures in sources.values()]
        table.add_row(name.replace("_", " "), f"{published}", *shown)
    total = sum(PAPER_VIEWS.values())
    for view in VIEWS.values():
        count = PAPER_VIEWS.get(view)
        shares = [percent_of(figures[f"dataset.share{{view={view}}}"]) for figures in sources.values()]
        table.add_row(f"view: {view.replace('_', '-')}", f"{count / total:.1%}" if count else "", *shares)
    return table


def headings(sources: Sources) -> Table:
    """Return table II: heading errors by method, mean absolute errors with their 95 % intervals."""
    table = _table("Table II: heading error e of single frames, modulo 90 degrees [deg]", "figure, method", sources)
    published: dict[str, tuple[str, Mapping[str, float | None]]] = {
        "mean": ("mean e", {name: both[0] for name, both in HEADING_DEG.items()}),
        "std": ("STD of e", {name: both[1] for name, both in HEADING_DEG.items()}),
        "abs_mean": ("mean |e|", {name: both[0] for name, both in HEADING_ABS_DEG.items()}),
        "abs_std": ("STD of |e|", {name: both[1] for name, both in HEADING_ABS_DEG.items()}),
    }
    for figure, (label, of_paper) in published.items():
        for method, value in of_paper.items():
            metrics = (figures[of_method(f"heading_{figure}_deg", method)] for figures in sources.values())
            shown = [_mean(metric) if figure == "abs_mean" else value_of(metric) for metric in metrics]
            table.add_row(f"{label}, {method}", NONE if value is None else f"{value:.3f}", *shown)
    return table


def distribution(sources: Sources) -> Table:
    """Return table III: the distribution of absolute heading errors.

    The paper's column "= 0" shows that it rounded headings to whole degrees; here it has errors below 0.5.
    """
    table = _table("Table III: share of |e| of at most; = 0 in whole degrees", "method, limit", sources)
    for method, of_paper in WITHIN.items():
        shares = {"= 0": "rounded_to_0deg", **{f"{limit} deg": f"within_{limit}deg" for limit in range(1, 6)}}
        for (label, name), value in zip(shares.items(), (ZERO[method], *of_paper), strict=True):
            shown = [_share(figures[of_method(name, method)]) for figures in sources.values()]
            table.add_row(f"{method}, {label}", f"{value:.1%}", *shown)
    return table


def positions(sources: Sources) -> Table:
    """Return table IV: position errors. The paper does not name its single model; here every model has rows."""
    table = _table("Table IV: absolute error of the tracked corner [m]", "targets, model, figure", sources)
    models = dict.fromkeys(model for figures in sources.values() for model in estimates(figures.run.models))
    for target, model in product(TARGETS, models):
        kind = "MMA" if model == MMA else "single"
        columns = [(axis, name) for axis in "xy" for name in ("mean", "std")]
        for (axis, name), value in zip(columns, POSITION_ABS_M[kind, target], strict=True):
            metric = filtered(f"mma.{axis}_abs_{name}_m", model=model, target=target)
            shown = [(_mean if name == "mean" else value_of)(figures[metric]) for figures in sources.values()]
            label = f"{target}, {model if kind == 'MMA' else f'single: {model}'}, {axis} {name.replace('std', 'STD')}"
            table.add_row(label, f"{value:.3f}", *shown)
    return table


TABLES: tuple[Callable[[Sources], Table], ...] = (data_set, headings, distribution, positions)
"""Tables I to IV."""


def verdict(name: str, figures: Figures) -> str:
    """Return one sentence: whether a run reproduces the paper's results.

    It does if the methods have the paper's order, and all mean absolute heading errors and position errors of the
    model selection deviate from the paper's by at most `TOLERANCE`.
    """
    published = {method: mean for method, (mean, _) in HEADING_ABS_DEG.items()}
    measured = {method: figures[of_method("heading_abs_mean_deg", method)].value for method in published}
    near = sum(_is_near(measured[method], value) for method, value in published.items())
    means = [(f"mma.{axis}_abs_mean_m{{target={target}}}", _mma(target, axis)) for target in TARGETS for axis in "xy"]
    near_positions = sum(_is_near(figures[metric].value, value) for metric, value in means)
    orders = [", ".join(_order(errors)) for errors in (measured, published)]
    all_hold = near == len(published) and near_positions == len(means) and orders[0] == orders[1]
    error = measured[BEST]
    return (
        f"{'Reproduced' if all_hold else 'Not reproduced'}: with {name}, best selection errs by "
        f"{NONE if error is None else f'{error:.2f}'} degrees (paper {published[BEST]:.2f}), "
        f"{near} of {len(published)} methods and {near_positions} of {len(means)} positions of {MMA} are within "
        f"{TOLERANCE:.0%} of the paper's figures, and by increasing error the methods are {orders[0]} "
        f"(paper: {orders[1]})."
    )


def _order(errors: Mapping[str, float | None]) -> list[str]:
    known = {method: math.inf if error is None else error for method, error in errors.items()}
    return sorted(known, key=known.__getitem__)


def _is_near(value: float | None, published: float) -> bool:
    return value is not None and abs(value - published) <= TOLERANCE * published


def _mma(target: str, axis: str) -> float:
    """Return the paper's mean position error of its model selection [m]."""
    x_mean, _, y_mean, _ = POSITION_ABS_M["MMA", target]
    return x_mean if axis == "x" else y_mean


def _table(title: str, first_column: str, sources: Iterable[str]) -> Table:
    return table_of(title, first_column, "paper", *sources)


def _mean(metric: Metric) -> str:
    if metric.interval is None:
        return value_of(metric)
    low, high = metric.interval
    return f"{value_of(metric)} [{low:.3f}, {high:.3f}]"


def _share(metric: Metric) -> str:
    if metric.interval is None:
        return percent_of(metric)
    low, high = metric.interval
    return f"{percent_of(metric)} [{100 * low:.0f}, {100 * high:.0f}]"
