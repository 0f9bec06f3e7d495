"""Figures of fit errors against range, aspect and visible fraction, and by class."""

from collections.abc import Sequence
from itertools import pairwise
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import pandas as pd

from luxloop.scenarios.arrays import Ints
from luxloop.scenarios.document.figure import Figure, note
from luxloop.scenarios.document.palette import BLUE, GREEN
from luxloop.scenarios.grading.plane_geometry import wrap
from luxloop.scenarios.metrics.definitions import DEFINITIONS
from luxloop.scenarios.statistics.jackknife import ratio_interval

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure as Canvas

WHISKER = 4.0
"""End of an axis, in multiples of the largest mean: the interval of few vehicles may be much longer."""
HEADING_DEG = DEFINITIONS["fit.heading_abs_mean_deg"].range
POSITION_M = DEFINITIONS["fit.position_abs_mean_m"].range


class Covariate(NamedTuple):
    """A quantity that the errors are shown against."""

    name: str
    label: str
    """Label of the axis."""
    column: str
    edges: Sequence[float]
    """Edges of the bins."""
    percent: bool = False


COVARIATES = (
    Covariate("range", "range [m]", "range_m", (0, 10, 20, 30, 40, 50)),
    Covariate("aspect", "aspect [deg]: 0 from ahead, 180 from behind", "aspect_deg", (0, 30, 60, 90, 120, 150, 180)),
    Covariate("visible fraction", "visible fraction [%]", "visible_fraction", (0, 0.2, 0.4, 0.6, 0.8, 1), percent=True),
)


def observations(fits: pd.DataFrame, truth: pd.DataFrame) -> pd.DataFrame:
    """Return the selected rectangles with `range_m`, `aspect_deg`, `visible_fraction` and the `kind` of the vehicle.

    The aspect is the angle at the vehicle between its heading and the line to the ego, 0 to 180 degrees.
    """
    best = fits[fits["best"] & fits["heading_error_deg"].notna()]
    to_ego = np.arctan2(-best["true_y_ego_m"].to_numpy(), -best["true_x_ego_m"].to_numpy())
    aspect = np.degrees(np.abs(wrap(to_ego - best["true_yaw_ego_rad"].to_numpy())))
    seen = truth[["frame", "actor_id", "visible_fraction", "kind"]]
    return best.assign(aspect_deg=aspect).merge(seen, on=["frame", "actor_id"], validate="one_to_one")


def errors_against(observed: pd.DataFrame, covariate: Covariate) -> Figure:
    """Draw mean absolute errors of fit heading and corner by bins of a covariate, with 95 % intervals."""
    scale = 100 if covariate.percent else 1
    names = [f"{scale * low:g}-{scale * high:g}" for low, high in pairwise(covariate.edges)]
    # The last bin includes its upper edge; graded observations are never beyond it.
    place = np.searchsorted(covariate.edges[1:-1], observed[covariate.column].to_numpy(), side="right")
    return _errors(observed, covariate.name, covariate.label, names, place)


def errors_by_class(observed: pd.DataFrame) -> Figure:
    """Draw the same errors by class of the vehicle, for the classes with fits."""
    kinds = observed["kind"].astype(str)
    names = sorted(kinds.unique())
    place = kinds.map({name: row for row, name in enumerate(names)}).to_numpy(np.int64)
    return _errors(observed, "class", "class of the vehicle", [name.replace("_", " ") for name in names], place)


def _errors(observed: pd.DataFrame, name: str, label: str, bins: list[str], place: Ints) -> Figure:
    """Draw the errors of fits by the bins that they are in."""

    def on(canvas: "Canvas") -> None:
        heading, position = canvas.subplots(2, 1, sharex=True)
        counts = np.bincount(place, minlength=len(bins))
        _means(heading, observed, place, observed["heading_error_deg"].abs(), HEADING_DEG, BLUE)
        _means(position, observed, place, observed["position_error_m"], POSITION_M, GREEN)
        heading.set_ylabel("fit heading [deg]")
        position.set_ylabel("nearest corner [m]")
        labels = [f"{one}\nn={count}" for one, count in zip(bins, counts, strict=True)]
        position.set_xticks(range(len(labels)), labels, fontsize=7.5)
        position.set(xlabel=label, xlim=(-0.5, max(len(bins), 1) - 0.5))

    caption = "Mean absolute error of the selected fits; whiskers are 95 % over vehicles, n counts fits."
    return Figure(f"error-{name.split()[0]}", f"Error of fits against {name}", caption, (5.2, 3.9), on)


def _means(
    axes: "Axes", observed: pd.DataFrame, place: Ints, error: pd.Series, within: tuple[float, float], color: str
) -> None:
    """Draw the mean of each bin with its interval."""
    top = 0.0
    for k in np.unique(place).tolist():
        inside = place == k
        value, vehicle = error.to_numpy()[inside], observed["actor_id"].to_numpy()[inside]
        interval = ratio_interval(vehicle, value, np.ones_like(value), within)
        axes.plot(k, value.mean(), "o", color=color, ms=5)
        top = max(top, value.mean())
        if interval:
            axes.plot([k, k], interval, "-", color=color, lw=1.2)
    if not len(place):
        note(axes, "no fits")
    axes.set_ylim(0.0, min(axes.get_ylim()[1], WHISKER * top) if top else None)
