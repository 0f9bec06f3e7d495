"""The paper's tables I to IV with its own figures beside those of runs, and whether they are reproduced."""

import math
from collections.abc import Callable, Iterable, Mapping
from itertools import product

from luxloop.scenarios.document.table import Table
from luxloop.scenarios.grading.figures import Figures
from luxloop.scenarios.metrics.definition import filtered
from luxloop.scenarios.metrics.definitions import TARGETS, VIEWS, estimates
from luxloop.scenarios.report import paper_figures
from luxloop.scenarios.report.cells import NONE, percent_of, table_of, value_of
from luxloop.scenarios.report.fit_tables import of_method
from luxloop.scenarios.result import Metric

Sources = Mapping[str, Figures]
"""Metrics of runs by the titles of their columns; at least one."""
TOLERANCE = 0.25
"""Largest deviation of a figure that is reproduced, as a share of the paper's."""
BEST, MMA = "best", "mma"


def data_set(sources: Sources) -> Table:
    """Return table I: the data set."""
    table = _table("Table I: data set", "category", sources)
    for name, published in paper_figures.DATASET.items():
        shown = [value_of(figures[f"dataset.{name}"], digits=1) for figures in sources.values()]
        table.add_row(name.replace("_", " "), f"{published}", *shown)
    total = sum(paper_figures.VIEWS.values())
    for view in VIEWS.values():
        count = paper_figures.VIEWS.get(view)
        shares = [percent_of(figures[f"dataset.share{{view={view}}}"]) for figures in sources.values()]
        table.add_row(f"view: {view.replace('_', '-')}", f"{count / total:.1%}" if count else "", *shares)
    return table


def headings(sources: Sources) -> Table:
    """Return table II: heading errors by method, mean absolute errors with their 95 % intervals."""
    table = _table("Table II: heading error e of single frames, modulo 90 degrees [deg]", "figure, method", sources)
    published: dict[str, tuple[str, Mapping[str, float | None]]] = {
        "mean": ("mean e", {name: both[0] for name, both in paper_figures.HEADING_DEG.items()}),
        "std": ("STD of e", {name: both[1] for name, both in paper_figures.HEADING_DEG.items()}),
        "abs_mean": ("mean |e|", {name: both[0] for name, both in paper_figures.HEADING_ABS_DEG.items()}),
        "abs_std": ("STD of |e|", {name: both[1] for name, both in paper_figures.HEADING_ABS_DEG.items()}),
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
    for method, of_paper in paper_figures.WITHIN.items():
        shares = {"= 0": "rounded_to_0deg", **{f"{limit} deg": f"within_{limit}deg" for limit in range(1, 6)}}
        for (label, name), value in zip(shares.items(), (paper_figures.ZERO[method], *of_paper), strict=True):
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
        for (axis, name), value in zip(columns, paper_figures.POSITION_ABS_M[kind, target], strict=True):
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
    published = {method: mean for method, (mean, _) in paper_figures.HEADING_ABS_DEG.items()}
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
    x_mean, _, y_mean, _ = paper_figures.POSITION_ABS_M["MMA", target]
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
