"""Print the table of the nets of SUMO's game in docs/any-city.md: `luxloop new` and `luxloop run` without an edit.

    pip download --no-deps eclipse-sumo    # or `pip install`; the folder is sumo/tools/game of the package
    python docs/game_nets.py FOLDER_OF_THE_GAME [FOLDER_OF_RUNS]

Every `.sumocfg` of the folder is a source, and every net that none of them names.
"""

import json
import re
import subprocess
import sys
import tempfile
import tomllib
from pathlib import Path

LONGEST = 220
"""Characters of a message in the table."""
EVENTS = (
    *("ego_collisions", "overlaps", "teleports", "insertions_in_view", "removals_in_view"),
    *("id_changes", "limit_violations"),
)
HEADS = (
    *("source", "ego", "class, window", "seconds", "vehicles", "observations", "HOTA"),
    *("events", "m/s², m/s³", "result"),
)


def main() -> None:
    """Print the table as Markdown."""
    game = Path(sys.argv[1]).resolve()
    with tempfile.TemporaryDirectory() as scratch:
        out = Path(sys.argv[2] if len(sys.argv) > 2 else scratch).resolve()
        out.mkdir(exist_ok=True)
        print(f"| {' | '.join(HEADS)} |")
        print(f"|{'---|' * len(HEADS)}")
        for source in sources(game):
            print(row(game, source, out), flush=True)


def sources(game: Path) -> list[Path]:
    """Return the configurations, and the nets that none of them names."""
    configurations = sorted(game.rglob("*.sumocfg"))
    named = {net.resolve() for path in configurations for net in nets_of(path)}
    nets = sorted([*game.rglob("*.net.xml"), *game.rglob("*.net.xml.gz")])
    return [*configurations, *(net for net in nets if net.resolve() not in named)]


def nets_of(configuration: Path) -> list[Path]:
    """Return the nets that a configuration names."""
    text = configuration.read_text(encoding="utf-8")
    return [configuration.parent / name for name in re.findall(r'<net-file value="([^"]+)"', text)]


def row(game: Path, source: Path, out: Path) -> str:
    """Return a row of the table: a run, or the message of a refusal."""
    name = str(source.relative_to(game))
    scenario = out / f"{re.sub(r'[^A-Za-z0-9]+', '-', name)}.toml"
    scenario.unlink(missing_ok=True)
    made = luxloop("new", str(source), "--out", str(scenario), "--json")
    if made.returncode:
        return f"| `{name}` | {' | '.join(8 * '-')} | refused: {message(made.stderr, game)} |"
    document = tomllib.loads(scenario.read_text(encoding="utf-8"))
    choices = json.loads(made.stdout)["choices"]
    found = re.search(r"\((\w+)\)", choices[0])
    start = re.search(r"from (\d+) s", " ".join(choices))
    cells = [f"`{name}`", document["traffic"]["ego"].partition(":")[2]]
    cells += [f"{found[1] if found else ''}, from {start[1] if start else '?'} s", f"{document['duration_s']:g}"]
    run = luxloop("run", str(scenario), "--json", "--no-recording", "--out", str(scenario.with_suffix("")))
    if run.returncode > 1:
        return f"| {' | '.join([*cells, *5 * '-'])} | code {run.returncode}: {message(run.stderr, game)} |"
    result = json.loads(run.stdout)
    metrics = {key: value["value"] for key, value in result["metrics"].items()}
    failed = ", ".join(f"`{name}`" for name in result["failed"])
    cells += [f"{metrics['dataset.vehicles']:g}", f"{metrics['dataset.observations']:g}"]
    cells += ["-" if metrics["track.hota"] is None else f"{metrics['track.hota']:.3f}"]
    cells += [events(metrics), f"{metrics['sim.acceleration_max_mps2']:.1f}, {metrics['sim.jerk_max_mps3']:.0f}"]
    end = "" if result["complete"] else f", {message(run.stderr, game)}"
    return "| " + " | ".join([*cells, result["verdict"] + (f": {failed}" if failed else "") + end]) + " |"


def events(metrics: dict[str, float | None]) -> str:
    """Return the numbers of truth events by kind."""
    found = {kind: metrics[f"sim.{kind}"] for kind in EVENTS}
    named = {kind.replace("_", " "): count for kind, count in found.items() if count}
    return ", ".join(f"{count:g} {kind if count != 1 else singular(kind)}" for kind, count in named.items()) or "none"


def singular(kind: str) -> str:
    """Return the name of one event."""
    return re.sub(r"s( in view)?$", r"\1", kind)


def luxloop(*arguments: str) -> "subprocess.CompletedProcess[str]":
    """Run a command of luxloop."""
    command = [sys.executable, "-m", "luxloop", *arguments]
    return subprocess.run(command, capture_output=True, text=True, check=False)


def message(stderr: str, game: Path) -> str:
    """Return the last line of an error, without the path of the game's folder."""
    line = (stderr.strip().splitlines() or [""])[-1].removeprefix("luxloop: error: ").replace(f"{game}/", "")
    return line if len(line) <= LONGEST else f"{line[:LONGEST]} ..."


if __name__ == "__main__":
    main()
