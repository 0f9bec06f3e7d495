"""Errors of fitted rectangles: heading, nearest corner, visible extents and overlap."""

import numpy as np
import pandas as pd

from luxloop.scenarios.arrays import Bools, Floats, Ints
from luxloop.scenarios.grading.plane_geometry import (
    QUARTER,
    corner,
    iou,
    matching_sign,
    nearest_sign,
    turned,
    wrap,
)
from luxloop.tracker.records import METHODS

BOX = ("x_ego_m", "y_ego_m", "heading_ego_rad", "length_m", "width_m")
"""Columns of a rectangle."""
TRUE_BOX = ("true_x_ego_m", "true_y_ego_m", "true_yaw_ego_rad", "true_length_m", "true_width_m")
"""Columns of the true box."""
SEEN = ("seen_length_m", "seen_width_m")
"""Columns of the visible extents."""


def measure(fits: pd.DataFrame) -> pd.DataFrame:
    """Add the errors of every rectangle, and mark the least heading error of each observation as `oracle`."""
    found = errors(fits)
    return found.assign(oracle=_oracle(fits["method"].cat.codes.to_numpy(), found["heading_error_deg"].to_numpy()))


def errors(fits: pd.DataFrame) -> pd.DataFrame:
    """Add the errors of every rectangle.

    Heading errors are modulo 90 degrees, in (-45, 45]. The position error is the distance from the rectangle's corner
    nearest to the ego to the same corner of the true box. The rectangle chooses the corner: for a vehicle abreast, with
    two equally near corners, independent choices could differ by the whole length. Its components are along and across
    the vehicle, positive outwards: the corner is beyond that of the true box. Errors of the extents, along and across,
    are the rectangle's extents minus those of the vehicle's true points.
    """
    box, true = fits[[*BOX]].to_numpy(np.float64), fits[[*TRUE_BOX]].to_numpy(np.float64)
    turn = box[:, 2] - true[:, 2]
    error = heading_errors(box, true)
    turn = np.where(np.isfinite(error), turn, 0.0)
    gap, true_sign = corner_gaps(box, true, turn)
    outwards = true_sign * turned(gap, -true[:, 2])
    sideways = np.round(turn / QUARTER) % 2 == 1
    size = np.where(sideways[:, None], box[:, :2:-1], box[:, 3:])
    extent = size - fits[[*SEEN]].to_numpy(np.float64)
    return fits.assign(
        heading_error_deg=error,
        box_heading_error_deg=np.degrees(wrap(fits["box_heading_ego_rad"].to_numpy() - true[:, 2], QUARTER)),
        position_error_m=np.hypot(gap[:, 0], gap[:, 1]),
        corner_along_error_m=outwards[:, 0],
        corner_across_error_m=outwards[:, 1],
        extent_along_error_m=extent[:, 0],
        extent_across_error_m=extent[:, 1],
        iou=iou(box, true),
    )


def heading_errors(box: Floats, true: Floats) -> Floats:
    """(N,) heading errors of rectangles (N, 5) modulo 90 degrees, in (-45, 45] [deg]."""
    error: Floats = np.degrees(wrap(box[:, 2] - true[:, 2], QUARTER))
    return error


def corner_gaps(box: Floats, true: Floats, turn: Floats) -> tuple[Floats, Ints]:
    """Return (N, 2) gaps from the true corner to the rectangle's nearest one, and (N, 2) signs of the true corner.

    Parameters
    ----------
    box, true
        (N, 5) rectangles and true boxes, about the ego.
    turn
        (N,) heading of the rectangle minus that of the true box [rad].
    """
    sign = nearest_sign(box)
    true_sign = matching_sign(sign, turn)
    return corner(box, sign) - corner(true, true_sign), true_sign


def _oracle(method: np.ndarray[tuple[int], np.dtype[np.int8]], error: Floats) -> Bools:
    """Mark the least error among each observation's `METHODS`; baselines are not selectable, NaN is skipped."""
    choice = np.flatnonzero(method < len(METHODS)).reshape(-1, len(METHODS))
    least = choice[np.arange(len(choice)), np.where(np.isfinite(error), np.abs(error), np.inf)[choice].argmin(axis=1)]
    oracle = np.zeros(len(error), dtype=np.bool_)
    oracle[least] = np.isfinite(error[least])
    return oracle


def with_regret(fitted: pd.DataFrame) -> pd.DataFrame:
    """Add `regret_deg`: the gain of a perfect selection among `METHODS`, NaN except for selected rectangles.

    The regret overstates the fault of the selection, because the least of several errors is partly small by chance.
    """
    key = ["frame", "actor_id"]
    oracle = fitted[fitted["oracle"]].set_index(key)["heading_error_deg"].abs()
    least = oracle.reindex(pd.MultiIndex.from_frame(fitted[key])).to_numpy()
    regret = fitted["heading_error_deg"].abs().to_numpy() - least
    return fitted.assign(regret_deg=np.where(fitted["best"], regret, np.nan))
