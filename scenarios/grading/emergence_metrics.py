"""Metrics of emergence, from its table: of the target, and of all actors of some classes."""

import numpy as np
import pandas as pd

from luxloop.scenarios.grading import kaplan_meier
from luxloop.scenarios.grading.emergence_table import COLUMNS
from luxloop.scenarios.grading.metric_sheet import MetricSheet
from luxloop.scenarios.metrics.definitions import EMERGING, END, MEASURES, STAGES, SURVIVAL

NO_TARGET = "the scenario names no grading.target"
OLDER = "the run was made by a version without the table emergence; run the scenario again"
NEVER = "never reached"
NEVER_FOR_HALF = "half of the actors or more never reached it"


def grade(sheet: MetricSheet, emergence: pd.DataFrame | None, target: str) -> None:
    """Enter the `emergence` metrics.

    Parameters
    ----------
    emergence
        Table of the run; None for a run of an earlier version.
    target
        Name of the target; empty for none.
    """
    table = pd.DataFrame(columns=list(COLUMNS)) if emergence is None else emergence
    rows = table[table["name"] == target].set_index("stage") if target else table[:0].set_index("stage")
    why = "" if len(rows) else _why_no_target(emergence, target)
    for stage in STAGES:
        _write_stage(sheet, stage, rows.loc[stage] if len(rows) else None, why)
    _write_end(sheet, rows, why)
    for group, kinds in list(EMERGING.items())[1:]:
        _write_group(sheet, group, table[table["kind"].isin(kinds)], OLDER if emergence is None else "")


def _why_no_target(emergence: pd.DataFrame | None, target: str) -> str:
    if not target:
        return NO_TARGET
    return OLDER if emergence is None else f'no actor is named "{target}"'


def _write_stage(sheet: MetricSheet, stage: str, row: pd.Series | None, why: str) -> None:
    """Enter all measures of the target at one stage; `row` is its row of the table."""
    reached = row is not None and bool(row["reached"])
    for name in [*MEASURES][:-1]:
        value = _number(row, name) if row is not None and reached else None
        sheet.write(_name(name, stage), value, int(value is not None), why or _why_none(name, reached))
    sheet.write(_name("reached", stage), None if row is None else float(reached), int(row is not None), why)


def _name(measure: str, stage: str, group: str = "") -> str:
    """Return the name of a measure of the target, or of a group."""
    return f"emergence.{measure}{{stage={stage}{f',group={group}' if group else ''}}}"


def _write_end(sheet: MetricSheet, rows: pd.DataFrame, why: str) -> None:
    """Enter the target's end of observation, which is that of a stage that is not reached, else not needed."""
    missed = rows[~rows["reached"].astype(bool)] if len(rows) else rows
    for name in SURVIVAL:
        value = _number(missed.iloc[0], name) if len(missed) else None
        reason = why or ("all stages are reached" if not len(missed) else _why_none(name, True))
        sheet.write(_name(name, END), value, int(value is not None), reason)


def _number(row: pd.Series, name: str) -> float | None:
    """Return a measure of a row, None if it does not exist."""
    value = float(row[name])
    return value if np.isfinite(value) else None


def _why_none(name: str, reached: bool) -> str:
    if not reached:
        return NEVER
    if name == "ttc_s":
        return "no collision course at constant velocities"
    return "the paths do not meet in the run" if name.startswith("meeting") else "no beam ever ended on it"


def _write_group(sheet: MetricSheet, group: str, rows: pd.DataFrame, why: str) -> None:
    """Enter the medians and shares of all actors of a group that any beam ended on."""
    seen = rows[rows["delay_s"].notna()]
    for stage in STAGES:
        found = seen[seen["stage"] == stage]
        none, reached = why or f"no beam ended on a {group}", found["reached"].to_numpy(np.bool_)
        delay = kaplan_meier.median(found["delay_s"].to_numpy(np.float64), reached)
        near = np.where(reached, found["range_m"].to_numpy(np.float64), -np.inf)
        range_m = float(np.quantile(near, 0.5, method="inverted_cdf")) if len(near) else -np.inf
        for name, value in (("delay_s", delay), ("range_m", range_m)):
            known = value if np.isfinite(value) else None
            sheet.write(_name(name, stage, group), known, len(found), NEVER_FOR_HALF if len(found) else none)
        sheet.mean(_name("reached", stage, group), reached, none)
    sheet.write(_name("delay_s", END, group), None, 0, "only the target has an end of observation")
