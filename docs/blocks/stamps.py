"""Stamps of blocks: the trace hashes of today's baseline, and digests of what a block shows."""

import hashlib
import re
from functools import cache
from importlib.metadata import version
from pathlib import Path

from luxloop.scenarios.compare import baseline_file
from luxloop.scenarios.compare.digest import RunDigest

BASELINE = Path(__file__).parents[2] / "scenarios" / "baseline" / "catalog.jsonl"
CATALOG = "catalog"
"""In place of a scenario: all runs of the baseline."""


@cache
def baseline() -> dict[str, RunDigest]:
    """Return the run of each scenario of the catalog with its own seed, from the baseline."""
    return {run.scenario: run for run in baseline_file.read(BASELINE)}


def runs(names: tuple[str, ...]) -> str:
    """Return the trace hashes of scenarios; that of the catalog is the MD5 digest of all of them."""
    known = {name: run.trace_hash for name, run in baseline().items()}
    whole = hashlib.md5("".join(known[name] for name in sorted(known)).encode()).hexdigest()
    return ", ".join(f"{name} {whole if name == CATALOG else known[name]}" for name in names)


def digest(page: Path, text: str) -> str:
    """Return a digest of a text and of the pictures to which it links."""
    found = hashlib.md5(text.encode())
    for target in re.findall(r"\]\(([^)]*pictures/[^)]+)\)", text):
        found.update((page.parent / target).read_bytes())
    return found.hexdigest()[:8]


def stamp(page: Path, text: str, hashes: str) -> str:
    """Return the stamp of a block that is written now."""
    return f"luxloop {version('luxloop')}, {hashes + ', ' if hashes else ''}content {digest(page, text)}"
