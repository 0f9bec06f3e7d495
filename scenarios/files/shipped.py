"""The shipped scenarios and studies, by name. Fast to import, for `luxloop list`."""

import tomllib
from difflib import get_close_matches
from pathlib import Path
from typing import Any, NamedTuple

from scenarios.errors import ScenarioError

CATALOG = Path(__file__).parents[1] / "catalog"
"""`<family>/<name>.toml`."""

STUDIES = Path(__file__).parents[1] / "studies"
"""`<name>.toml`; base scenarios of some studies are in the subfolder `scenes`."""


class Entry(NamedTuple):
    """A line of `luxloop list`."""

    family: str
    name: str
    description: str


def paths() -> dict[str, Path]:
    """Return the files of the shipped scenarios by name, in the order of family and name."""
    return {path.stem: path for path in sorted(CATALOG.glob("*/*.toml"))}


def entries() -> list[Entry]:
    """Return every shipped scenario with its description."""
    return [Entry(path.parent.name, name, _document(path)["description"]) for name, path in paths().items()]


def study_entries() -> list[Entry]:
    """Return every shipped study; its family is the command that runs it."""
    documents = {name: _document(path) for name, path in studies().items()}
    return [
        Entry("search" if "search" in document else "sweep", name, document["description"])
        for name, document in documents.items()
    ]


def studies() -> dict[str, Path]:
    """Return the files of the shipped studies by name."""
    return {path.stem: path for path in sorted(STUDIES.glob("*.toml"))}


def find(name_or_path: str) -> Path:
    """Return the file of a scenario, given by its name in `luxloop list` or by a path that ends in .toml.

    Raises
    ------
    ScenarioError
        No shipped scenario has that name.
    """
    if name_or_path.endswith(".toml"):
        return Path(name_or_path)
    shipped = paths()
    if name_or_path not in shipped:
        close = get_close_matches(name_or_path, shipped, n=3, cutoff=0.4)
        hint = f"did you mean {', '.join(close)}?" if close else "see luxloop list"
        raise ScenarioError(f"{name_or_path}: no such scenario; {hint} (a path must end in .toml)")
    return shipped[name_or_path]


def _document(path: Path) -> dict[str, Any]:
    return tomllib.loads(path.read_text(encoding="utf-8"))
