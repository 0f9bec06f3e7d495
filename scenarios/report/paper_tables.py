"""The paper's four tables for one run; `paper_comparison` has the paper's figures beside them."""

from itertools import product

from luxloop.scenarios.document.table import Table
from luxloop.scenarios.metrics.definition import filtered
from luxloop.scenarios.metrics.definitions import NO_VIEW, TARGETS, VIEWS, estimates
from luxloop.scenarios.report.cells import interval_of, percent_of, table_of, value_of
from luxloop.scenarios.report.fit_tables import emphasis, methods_of, of_method
from luxloop.scenarios.result import Metric, Result


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
