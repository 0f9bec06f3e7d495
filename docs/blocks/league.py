"""Tables and picture of a league."""

import json
import shutil
from pathlib import Path
from typing import Any

from blocks import commands

PICTURE = Path(__file__).parents[1] / "pictures" / "league.png"
OUT = commands.RUNS / "league"
DIFFERENCES = {
    "track.hota": "HOTA", "track.id_switch_rate": "id switches", "track.false_share": "false",
    "track.missed_share": "missed", "track.gospa_m": "GOSPA [m]",
}  # fmt: skip


def tables(_name: str) -> str:
    """Return standings, differences, scores by scenario, and where the shipped tracker is not the best."""
    found = result()
    return "\n\n".join([summary(found), standings(found), differences(found), scenarios(found), behind(found)])


def picture(_name: str) -> None:
    """Copy the picture of the standings."""
    result()
    shutil.copyfile(OUT / "hota.png", PICTURE)


def result() -> dict[str, Any]:
    """Return the league's result; finished runs are taken up."""
    commands.output(f"luxloop league --out {OUT.relative_to(commands.ROOT)}")
    found: dict[str, Any] = json.loads((OUT / "league.json").read_text(encoding="utf-8"))
    return found


def summary(found: dict[str, Any]) -> str:
    """Return the size of the league and its result in a paragraph."""
    seeds = ", ".join(map(str, found["seeds"]))
    size = f"{len(found['scenarios'])} scenarios, seeds {seeds}, {found['duration_max_s']:g} s each"
    runs = f"{len(found['rows'])} runs: {size}"
    return f"{runs}. {found['answer']}."


def standings(found: dict[str, Any]) -> str:
    """Return the table of all trackers."""
    lines = ["| tracker | HOTA | 95 % | id switches | GOSPA [m] | false | missed | step time | runs, failed |",
             "|---|---|---|---|---|---|---|---|---|"]  # fmt: skip
    for each in found["standings"]:
        low, high = each["hota_interval"]
        counts = each["counts"]
        cells = [
            each["tracker"], number(each["hota"]), f"{number(low)} to {number(high)}", counts["id_switches"],
            number(each["gospa_m"]), counts["false"], counts["missed"], f"{each['step_ratio']:.1f}",
            f"{each['runs']}, {each['failed']}",
        ]  # fmt: skip
        lines.append(f"| {' | '.join(map(str, cells))} |")
    return "\n".join(lines)


def differences(found: dict[str, Any]) -> str:
    """Return the table of paired differences; those whose interval excludes 0 are bold."""
    lines = [f"| tracker, difference to shipped | {' | '.join(DIFFERENCES.values())} |", "|---" * 6 + "|"]
    for each in found["standings"]:
        if each["differences"]:
            cells = [difference(each["differences"][name]) for name in DIFFERENCES]
            lines.append(f"| {each['tracker']} | {' | '.join(cells)} |")
    return "\n".join(lines)


def difference(each: dict[str, Any]) -> str:
    """Return a difference with its interval."""
    low, high = each["interval"]
    if low is None:
        return number(each["difference"])
    text = f"{each['difference']:+.3f} ({low:+.3f} to {high:+.3f})"
    return f"**{text}**" if low > 0.0 or high < 0.0 else text


def scenarios(found: dict[str, Any]) -> str:
    """Return HOTA by scenario; the highest is bold."""
    trackers = found["standings"]
    lines = [f"| HOTA in | {' | '.join(each['tracker'] for each in trackers)} |", "|---" * (len(trackers) + 1) + "|"]
    for name in found["scenarios"]:
        values = [each["hota_by_scenario"].get(name) for each in trackers]
        best = max((value for value in values if value is not None), default=None)
        cells = [f"**{number(value)}**" if value == best else number(value) for value in values]
        lines.append(f"| {Path(name).stem} | {' | '.join(cells)} |")
    return "\n".join(lines)


def behind(found: dict[str, Any]) -> str:
    """Return where the shipped tracker is not the best, with the commands that measure why."""
    lines = [f"- {line}" for line in found["behind"]] or ["The shipped tracker is the best in every column."]
    commands = ["```sh", *found["blame"], "```"] if found["blame"] else []
    return "\n".join([*lines, *([""] if commands else []), *commands])


def number(value: float | None) -> str:
    """Return a figure with three decimals."""
    return "n/a" if value is None else f"{value:.3f}"
