"""The scenarios that ship, and how one is found by its name. Light to import: `luxloop list` needs nothing else."""

import tomllib
from difflib import get_close_matches
from pathlib import Path
from typing import NamedTuple

from scenarios.errors import ScenarioError

CATALOG = Path(__file__).parent / "catalog"
"""`<family>/<name>.toml`."""


class Entry(NamedTuple):
    """One line of `luxloop list`."""

    family: str
    name: str
    description: str


def paths() -> dict[str, Path]:
    """Files of the shipped scenarios by name, in the order of family and name."""
    return {path.stem: path for path in sorted(CATALOG.glob("*/*.toml"))}


def entries() -> list[Entry]:
    """Every shipped scenario with its sentence."""
    return [
        Entry(path.parent.name, name, tomllib.loads(path.read_text(encoding="utf-8"))["description"])
        for name, path in paths().items()
    ]


def find(name_or_path: str) -> Path:
    """Return the file of a scenario named as in `luxloop list`, or given by its path (which ends in .toml).

    Raises
    ------
    ScenarioError
        There is none of that name.
    """
    if name_or_path.endswith(".toml"):
        return Path(name_or_path)
    shipped = paths()
    if name_or_path not in shipped:
        close = get_close_matches(name_or_path, shipped, n=3, cutoff=0.4)
        hint = f"did you mean {', '.join(close)}?" if close else "see luxloop list"
        raise ScenarioError(f"{name_or_path}: no such scenario; {hint} (a path must end in .toml)")
    return shipped[name_or_path]
