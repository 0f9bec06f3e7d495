"""Write the tables and the picture of a league into `docs/league.md` and `docs/pictures/league.png`.

    luxloop league --out FOLDER
    python docs/draw_league.py FOLDER [--wall-minutes M]

The tables are between `<!-- league -->` and `<!-- end -->`.
"""

import argparse
import json
import shutil
from pathlib import Path
from typing import Any

from fits import page

DOCS = Path(__file__).parent
PAGE, PICTURE = DOCS / "league.md", DOCS / "pictures" / "league.png"
DIFFERENCES = {
    "track.hota": "HOTA", "track.id_switch_rate": "id switches", "track.false_share": "false",
    "track.missed_share": "missed", "track.gospa_m": "GOSPA [m]",
}  # fmt: skip


def main() -> None:
    """Write both files."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path, help="folder of luxloop league")
    parser.add_argument("--wall-minutes", type=float, help="wall time of the command on two cores")
    given = parser.parse_args()
    found = json.loads((given.folder / "league.json").read_text(encoding="utf-8"))
    parts = [summary(found, given.wall_minutes), standings(found), differences(found), scenarios(found), behind(found)]
    page.replace("league", "\n\n".join(parts), PAGE)
    shutil.copyfile(given.folder / "hota.png", PICTURE)


def summary(found: dict[str, Any], minutes: float | None) -> str:
    """Return the size of the league and its result in a paragraph."""
    seeds = ", ".join(map(str, found["seeds"]))
    size = f"{len(found['scenarios'])} scenarios, seeds {seeds}, {found['duration_max_s']:g} s each"
    runs = f"{len(found['rows'])} runs: {size}"
    wall = f" They took {minutes:g} minutes on two cores." if minutes else ""
    return f"{runs}.{wall} {found['answer']}."


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


if __name__ == "__main__":
    main()
