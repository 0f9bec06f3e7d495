"""How safely the ego drove, from the truth alone, whoever drove it."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd

from scenarios.control.corridor import lead_of
from scenarios.control.surroundings import truth_around
from scenarios.grading.metric_names import DRIVERS, SAFETY
from scenarios.grading.metric_sheet import MetricSheet
from scenarios.grading.plane_geometry import iou_table, turned
from scenarios.result import Metric
from sim.world import WorldFrame

NO_CONTROL = "the scenario has no [control]: its ego is driven by the traffic's own model"
NOBODY_AHEAD = "nobody was ever in the ego's way"
NEVER_CLOSING = "the ego never closed in on anybody in its way"
NO_FRAME = "the drive ended before its first frame"

COLUMNS = (
    "frame", "time_s", "speed_mps", "acceleration_mps2", "wanted_mps", "gap_m", "closing_mps", "ttc_s", "collides",
)  # fmt: skip
"""Of the table, one row per frame and drive; `driver` comes last."""


class SafetyLog:
    """Takes down the truth of a drive, frame by frame.

    In the ego's way is who reaches into the strip that its body will sweep if it keeps turning as it does. The time
    to collision is the gap over the speed at which it closes (Hayward, "Near-miss determination through use of a scale
    of danger", Highway Research Record 384, 1972); where nothing closes there is none.
    """

    def __init__(self) -> None:
        self._rows: list[tuple[Any, ...]] = []
        self._hit: set[int] = set()

    def add(self, frame: WorldFrame, wanted_mps: float | None) -> None:
        """Take the next frame, and the speed that was commanded in it, if any."""
        ego, around = frame.ego, truth_around(frame)
        lead = lead_of(around, half_width_m=0.5 * float(ego.size[1]))
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
        """One row per frame; NaN where nobody is in the way, where the gap does not close, before the first command."""
        return pd.DataFrame(self._rows, columns=list(COLUMNS))

    def collisions(self) -> int:
        """With how many others the ego's box ever overlapped."""
        return len(self._hit)


def grade(drives: Mapping[str, SafetyLog]) -> tuple[dict[str, Metric], dict[str, pd.DataFrame]]:
    """Return every metric of `metrics.CONTROL`, and the table behind them, from drives by driver; there may be none."""
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
    why = NEVER_CLOSING if len(gap) else NOBODY_AHEAD
    sheet.write(f"control.{prefix}min_ttc_s", ttc.min(), len(ttc), why)
    sheet.write(f"control.{prefix}min_gap_m", gap.min(), len(gap), NOBODY_AHEAD)
    sheet.write(f"control.{prefix}max_deceleration_mps2", max(braking.max(), 0.0), frames, NO_FRAME)
    sheet.write(f"control.{prefix}collisions", float(collisions), frames, NO_FRAME)


def _write_none(sheet: MetricSheet, prefix: str) -> None:
    for name in SAFETY:
        sheet.write(f"control.{prefix}{name}", None, 0, NO_CONTROL)
