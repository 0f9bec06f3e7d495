"""Safety metrics of the ego's drive, from the ground truth: time to collision, gap, deceleration, collisions."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd

from luxloop.scenarios.control.surroundings import find_lead, true_surroundings
from luxloop.scenarios.grading.metric_sheet import MetricSheet
from luxloop.scenarios.grading.plane_geometry import iou_table, turned
from luxloop.scenarios.metrics.definitions import DRIVERS, SAFETY
from luxloop.scenarios.result import Metric
from luxloop.sim.world import WorldFrame

NO_CONTROL = "the scenario has no [control]: the traffic model drives the ego"
NO_LEAD = "there was no lead vehicle"
NEVER_CLOSING = "the ego was never faster than its lead vehicle"
NO_FRAME = "the drive ended before its first frame"

COLUMNS = (
    "frame", "time_s", "speed_mps", "acceleration_mps2", "wanted_mps", "gap_m", "closing_mps", "ttc_s", "collides",
)  # fmt: skip
"""Columns of the table, which has one row per frame and drive; a column `driver` is appended."""


class SafetyLog:
    """Records the ground truth of a drive, frame by frame.

    The lead vehicle is the nearest one in the corridor that the ego's body will cover at its present curvature. The
    time to collision is the gap divided by the closing speed (Hayward, "Near-miss determination through use of a scale
    of danger", Highway Research Record 384, 1972); it is undefined if the gap does not close.
    """

    def __init__(self) -> None:
        self._rows: list[tuple[Any, ...]] = []
        self._hit: set[int] = set()

    def add(self, frame: WorldFrame, wanted_mps: float | None) -> None:
        """Record the next frame, and the speed commanded in it, if any."""
        ego, around = frame.ego, true_surroundings(frame)
        lead = find_lead(around, half_width_m=0.5 * float(ego.size[1]))
        body = np.array([[0.0, 0.0, 0.0, *ego.size[:2]]])
        overlaps = iou_table(body, around.boxes_ego)[0] > 0
        self._hit.update(around.id[overlaps].tolist())
        gap, closing = (lead.gap, around.speed - lead.speed) if lead else (np.nan, np.nan)
        ttc = max(gap, 0.0) / closing if closing > 0 else np.nan
        acceleration = turned(ego.acceleration_world, -ego.pose_world[2])[0]
        wanted = np.nan if wanted_mps is None else wanted_mps
        row = (frame.index, frame.time, around.speed, acceleration, wanted, gap, closing, ttc, overlaps.any())
        self._rows.append(row)

    def table(self) -> pd.DataFrame:
        """Return one row per frame; NaN without a lead vehicle, without a closing gap, and before the first command."""
        return pd.DataFrame(self._rows, columns=list(COLUMNS))

    def collisions(self) -> int:
        """Return the number of actors whose box ever overlapped the ego's box."""
        return len(self._hit)


def grade(drives: Mapping[str, SafetyLog]) -> tuple[dict[str, Metric], dict[str, pd.DataFrame]]:
    """Return every metric of `kind `control`` and their table, from the logs by driver; a log may be missing."""
    sheet, tables = MetricSheet(), []
    for driver, prefix in DRIVERS.items():
        if (log := drives.get(driver)) is not None:
            tables.append(log.table().assign(driver=driver))
            _write(sheet, prefix, tables[-1], log.collisions())
        else:
            _write_none(sheet, prefix)
    return sheet.metrics, {"control": pd.concat(tables, ignore_index=True)} if tables else {}


def _write(sheet: MetricSheet, prefix: str, table: pd.DataFrame, collisions: int) -> None:
    frames, gap, ttc = len(table), table["gap_m"].dropna(), table["ttc_s"].dropna()
    braking = -table["acceleration_mps2"]
    why = NEVER_CLOSING if len(gap) else NO_LEAD
    sheet.write(f"control.{prefix}min_ttc_s", ttc.min(), len(ttc), why)
    sheet.write(f"control.{prefix}min_gap_m", gap.min(), len(gap), NO_LEAD)
    sheet.write(f"control.{prefix}max_deceleration_mps2", max(braking.max(), 0.0), frames, NO_FRAME)
    sheet.write(f"control.{prefix}collisions", float(collisions), frames, NO_FRAME)


def _write_none(sheet: MetricSheet, prefix: str) -> None:
    for name in SAFETY:
        sheet.write(f"control.{prefix}{name}", None, 0, NO_CONTROL)
