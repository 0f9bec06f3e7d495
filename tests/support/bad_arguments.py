"""Command lines with broken arguments."""

import random
import re

from support.mutate_content import NUMBERS, TEXTS

VALUES = [text for text in (*TEXTS, *NUMBERS) if "\0" not in text and not re.fullmatch(r"[./~]+", text)]
"""Without NUL, which the kernel passes to no program, and without folders full of other files."""
COMMANDS = (
    "run a.toml --no-recording --out out --seed 3 --duration 0.16",
    "run a.toml --no-recording --out out --set noise.ideal=true --set traffic.actor[0].x_m=9 --json",
    "run a.toml --no-recording --quiet --out out --seeds 1-1",
    "run a.toml --no-recording --out out --tracker luxloop.tracker.tracker:Tracker --step-timeout 60 --quiet",
    "run a.toml --no-recording --out out --oracle detector --dataset data --quiet",
    "list --family highway --kind sumo --suite smoke --json",
    "grade run --tracks tracks.csv --scenario a.toml --out out --json",
    "report run --out page.html",
    "compare base.jsonl head.jsonl --loss 2 --report page.html",
    "baseline run --out other.jsonl",
    "trends base.jsonl head.jsonl --out trends.html",
    "import a.bin --mount 0,0,1 --out out --layers 0,1 --keep-heights 0,2 --rate 10 --scale-length 1 --scale-time 1",
    "import a.bin --mount 0,0,1,0,0,0 --out out --heights 0.5 --height-tolerance 0.1 --azimuth-step 0.5 --format bin",
    "sweep study.toml --scheduler 127.0.0.1:9 --out out --seeds 1-2 --figures svg",
    "paper run --table 3 --latex",
    "mcap run a.mcap",
    "schema --study",
    "check-tracker tracker.nowhere:Tracker",
    "realism data --real table.csv --out out",
    "track rec --scenario a.toml --out out",
    "blame nowhere.toml --duration 0.16",
    "search study.toml --scheduler 127.0.0.1:9 --out out",
    "view run --web --frame 3",
)
EXTRA = (
    "--help",
    "--version",
    "--nothing",
    "-x",
    "--",
    "-",
    "--out",
    "--json=1",
    "--seed=9e9",
    "--quiet",
    "\x1b[2J",
    "--set",
)


def arguments(rng: random.Random) -> tuple[list[str], str]:
    """Return a command line with one to three broken arguments, and what was done to it."""
    words = rng.choice(COMMANDS).split()
    original = list(words)
    for _ in range(rng.choice((1, 1, 2, 3))):
        at = rng.randrange(len(words)) if len(words) > 1 else 0
        value = rng.choice(VALUES)
        way = rng.randrange(5)
        if way == 0 and len(words) > 1:
            del words[at]
        elif way == 1:
            words.insert(at, rng.choice(EXTRA))
        elif way == 2 and "=" in words[at]:
            words[at] = words[at].partition("=")[0] + "=" + value
        elif way == 3 and at:
            words[at] = words[at][: rng.randrange(len(words[at]) + 1)] + value
        elif at:
            words[at] = value
    first = words[:1]
    if first == ["view"]:
        words = ["view", "nowhere", *words[1:2]]  # a run would open a window
    if first == ["paper"] and original[1] not in words:
        words.append(original[1])  # without a run, it simulates one
    if first in (["sweep"], ["search"]) and "--scheduler" not in words:
        words = original  # it would start workers
    return words, "arguments"
