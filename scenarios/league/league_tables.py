"""Tables of the league, for the terminal and for the page."""

import math
from collections.abc import Sequence

from luxloop.scenarios.document.document import Table
from luxloop.scenarios.league.entrants import Entrant
from luxloop.scenarios.league.league_runs import Row
from luxloop.scenarios.league.standings import GOSPA, PairedDifference, Standing
from luxloop.scenarios.report.cells import NONE, table_of
from luxloop.scenarios.run.device import REFERENCE

SHORT = {
    "track.hota": "HOTA", "track.id_switch_rate": "id switches per observation", "track.false_share": "false rate",
    "track.missed_share": "missed rate", GOSPA: "GOSPA [m]",
}  # fmt: skip


def standings_table(found: Sequence[Standing]) -> Table:
    """Return the figures of each tracker, the highest HOTA first."""
    columns = ("HOTA", "95 %", "id switches", "GOSPA [m]", "false", "missed", "step time", "runs", "failed")
    table = table_of("Standings", "tracker", *columns)
    for each in found:
        counts = [str(each.counts[name]) if each.runs else NONE for name in ("id_switches", "false", "missed")]
        table.add_row(
            each.tracker,
            number(each.hota),
            interval(each.hota_interval),
            counts[0],
            number(each.gospa_m),
            *counts[1:],
            NONE if math.isnan(each.step_ratio) else f"{each.step_ratio:.2f}x",
            str(each.runs),
            str(each.failed),
            style="bold" if each.tracker == REFERENCE else "",
        )
    return table


def differences_table(found: Sequence[Standing]) -> Table:
    """Return the paired differences to the shipped tracker; intervals without 0 have a star."""
    table = table_of("Differences to the shipped tracker, 95 % intervals", "tracker", *SHORT.values())
    for each in found:
        if each.differences:
            table.add_row(each.tracker, *(_difference(each.differences[name]) for name in SHORT))
    return table


def scenario_table(found: Sequence[Standing]) -> Table:
    """Return HOTA by scenario."""
    table = table_of("HOTA by scenario", "scenario", *(each.tracker for each in found))
    for scenario in sorted({name for each in found for name in each.hota_by_scenario}):
        values = [each.hota_by_scenario.get(scenario, math.nan) for each in found]
        best = max((value for value in values if math.isfinite(value)), default=math.nan)
        table.add_row(scenario, *(f"{number(value)}{' *' if value == best else ''}" for value in values))
    return table


def entrants_table(trackers: Sequence[Entrant]) -> Table:
    """Return association, filter and settings of each tracker."""
    table = table_of("Trackers", "tracker", "method", "settings other than the defaults")
    for entrant in trackers:
        table.add_row(entrant.name, entrant.text, ", ".join(f"{k} {v}" for k, v in entrant.settings.items()) or "none")
    return table


def failures_table(rows: Sequence[Row]) -> Table:
    """Return the runs without a result, with their errors."""
    table = table_of("Runs without a result", "run", "error")
    for row in rows:
        if row["status"] != "finished":
            table.add_row(f"{row['tracker']}, {row['scenario']} seed {row['seed']}", f"{row['status']}: {row['error']}")
    return table


def number(value: float) -> str:
    """Return a figure with three decimals."""
    return f"{value:.3f}" if math.isfinite(value) else NONE


def interval(ends: tuple[float, float]) -> str:
    """Return an interval; empty without one."""
    return f"{ends[0]:.3f} to {ends[1]:.3f}" if math.isfinite(ends[0]) else ""


def _difference(each: PairedDifference) -> str:
    if not math.isfinite(each.difference):
        return NONE
    low, high = each.interval
    spread = f" ({low:+.3f} to {high:+.3f})" if math.isfinite(low) else ""
    return f"{each.difference:+.3f}{spread}{' *' if each.clear else ''}"
