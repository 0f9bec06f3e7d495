"""The paper's four tables of both trackers as Markdown, each beside the paper's figures."""

from collections.abc import Iterator, Mapping, Sequence
from itertools import product

from fits.league_tables import markdown
from variants.pooled import Pooled

from luxloop.scenarios.metrics.definitions import NO_VIEW, TARGETS, VIEWS, estimates
from luxloop.scenarios.report import paper_comparison
from luxloop.scenarios.report.cells import interval_of, percent_of, value_of
from luxloop.scenarios.result import Metric

Trackers = Mapping[str, Mapping[str, Pooled]]
"""Runs by the name of their tracker, then by that of their seeds."""

SHOWN = (*paper_comparison.HEADING_DEG, "oracle")
"""Methods of table II: the paper's, and the best choice among the candidates."""


SHARES = ("rounded_to_0deg", *(f"within_{limit}deg" for limit in range(1, 6)))
"""Columns of table III."""


def table_1(trackers: Trackers) -> str:
    """Return the data set, per drive; it does not depend on the tracker."""
    sets = next(iter(trackers.values()))
    total, rows = sum(paper_comparison.PAPER_VIEWS.values()), []
    for name, published in paper_comparison.DATASET.items():
        rows.append((name.replace("_", " "), *(_per_drive(one, f"dataset.{name}") for one in sets.values()), published))
    for view in (*VIEWS.values(), NO_VIEW):
        shares = [percent_of(one.metrics[f"dataset.share{{view={view}}}"]) for one in sets.values()]
        published = paper_comparison.PAPER_VIEWS.get(view)
        rows.append((f"view: {view.replace('_', '-')}", *shares, f"{published / total:.1%}" if published else ""))
    return markdown(("per drive", *sets, "paper"), rows)


def table_2(trackers: Trackers) -> str:
    """Return heading errors: mean and STD, then mean absolute error with its interval and STD of absolute errors."""
    signed, absolute = "mean, STD", "mean abs. [95 %], STD"
    seeds = list(next(iter(trackers.values())))
    head = ("method", "tracker", *(f"{name}: {what}" for name in (*seeds, "paper") for what in (signed, absolute)))
    rows = []
    for method, (tracker, sets) in product(SHOWN, trackers.items()):
        cells = []
        for one in sets.values():
            mean, std, size, size_std = (
                one.metrics[f"fit.heading_{name}_deg{{method={method}}}"]
                for name in ("mean", "std", "abs_mean", "abs_std")
            )
            cells += [f"{value_of(mean)}, {value_of(std)}", f"{_with_interval(size)}, {value_of(size_std)}"]
        rows.append((f"`{method}`", tracker, *cells, *_published_headings(method)))
    return markdown(head, rows)


def table_3(trackers: Trackers) -> str:
    """Return the distribution of heading errors of the paper's two methods."""
    head = ("method", "tracker", "seeds", "= 0", *(f"{limit} deg" for limit in range(1, 6)))
    rows: list[Sequence[object]] = []
    for method, published in paper_comparison.WITHIN.items():
        for tracker, sets in trackers.items():
            for name, one in sets.items():
                shares = [_share(one.metrics[f"fit.{share}{{method={method}}}"]) for share in SHARES]
                rows.append((f"`{method}`", tracker, name, *shares))
        paper = (paper_comparison.ZERO[method], *published)
        rows.append((f"`{method}`", "the paper's", "", *(f"{100 * share:.1f} %" for share in paper)))
    return markdown(head, rows)


def table_4(trackers: Trackers) -> str:
    """Return position errors: mean with its interval, and STD, of each axis."""
    seeds = list(next(iter(trackers.values())))
    head = ("targets", "model", "tracker", *(f"{name}: {axis} mean [95 %], STD" for name in seeds for axis in "xy"))
    rows: list[Sequence[object]] = []
    for target in TARGETS:
        for model in estimates(_models(trackers)):
            for tracker, sets in trackers.items():
                cells = [_position(one.metrics, model, target, axis) for one in sets.values() for axis in "xy"]
                rows.append((target, f"`{model}`", tracker, *cells))
        rows += _published_positions(target, len(seeds))
    return markdown(head, rows)


def _models(trackers: Trackers) -> tuple[str, ...]:
    """Return the motion models of all trackers, which have the same ones."""
    return next(iter(next(iter(trackers.values())).values())).models


def _per_drive(one: Pooled, name: str) -> str:
    metric = one.metrics[name]
    if metric.value is None or metric.unit != "count":
        return value_of(metric, digits=1)
    return f"{metric.value / one.drives:.0f}"


def _with_interval(metric: Metric) -> str:
    interval = interval_of(metric).replace("-", ", ")  # magnitudes: no sign
    return f"{value_of(metric)} [{interval}]" if interval else value_of(metric)


def _share(share: Metric) -> str:
    interval = interval_of(share, percent=True).replace("-", ", ")
    shown = percent_of(share).replace("%", " %")
    return f"{shown} [{interval}]" if interval else shown


def _position(metrics: Mapping[str, Metric], model: str, target: str, axis: str) -> str:
    mean, std = (metrics[f"mma.{axis}_abs_{name}_m{{model={model},target={target}}}"] for name in ("mean", "std"))
    return f"{_with_interval(mean)}, {value_of(std)}"


def _published_headings(method: str) -> tuple[str, str]:
    """Return the paper's cells of a method; empty for those that it does not have."""
    if method not in paper_comparison.HEADING_DEG:
        return "", ""
    shown = [
        "n/a" if value is None else f"{value:.3f}"
        for value in (*paper_comparison.HEADING_DEG[method], *paper_comparison.HEADING_ABS_DEG[method])
    ]
    return ", ".join(shown[:2]), ", ".join(shown[2:])


def _published_positions(kind: str, repeats: int) -> Iterator[Sequence[object]]:
    """Yield the paper's rows, with the figures in the columns of the first seeds."""
    for (model, targets), (x_mean, x_std, y_mean, y_std) in paper_comparison.POSITION_ABS_M.items():
        if targets == kind:
            cells = (f"{x_mean:.3f}, {x_std:.3f}", f"{y_mean:.3f}, {y_std:.3f}")
            yield (kind, model, "the paper's", *cells, *[""] * (2 * (repeats - 1)))
