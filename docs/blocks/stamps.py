"""Stamps of blocks: the trace hashes of today's baseline, and digests of what a block shows."""

import hashlib
import json
import re
from functools import cache
from importlib.metadata import version
from pathlib import Path
from typing import Any

BASELINE = Path(__file__).parents[2] / "scenarios" / "baseline" / "catalog.jsonl"
CATALOG = "catalog"
"""In place of a scenario: all runs of the baseline."""


@cache
def baseline() -> list[dict[str, Any]]:
    """Return the runs of the baseline: each scenario of the catalog with its own seed."""
    return [json.loads(line) for line in BASELINE.read_text(encoding="utf-8").splitlines()[1:]]


@cache
def trace_hashes() -> dict[str, str]:
    """Return the trace hash of each scenario of the catalog."""
    return {run["scenario"]: run["trace_hash"] for run in baseline()}


def expected_values() -> dict[str, dict[str, float]]:
    """Return the values of the expected metrics of each scenario."""
    return {
        run["scenario"]: {metric: found["value"] for metric, found in run["expectations"].items()} for run in baseline()
    }


def runs(names: tuple[str, ...]) -> str:
    """Return the trace hashes of scenarios; that of the catalog is the MD5 digest of all of them."""
    known = trace_hashes()
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
