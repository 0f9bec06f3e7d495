"""The shipped scenarios and studies, by name. Fast to import, for `luxloop list`."""

import tomllib
from collections.abc import Iterable
from difflib import get_close_matches
from pathlib import Path
from typing import Any, NamedTuple

from luxloop.scenarios.errors import InputError, ScenarioError

CATALOG = Path(__file__).parents[1] / "catalog"
"""`<family>/<name>.toml`."""

STUDIES = Path(__file__).parents[1] / "studies"
"""`<name>.toml`; base scenarios of some studies are in the subfolder `scenes`."""


class Entry(NamedTuple):
    """A line of `luxloop list`."""

    family: str
    name: str
    description: str
    kind: str = ""
    """Kind of traffic of a scenario."""
    suite: str = ""
    duration_s: float | None = None
    path: Path = Path()

    def contains(self, words: Iterable[str]) -> bool:
        """Return True if each word is in the name or the description, in any case."""
        text = f"{self.name} {self.description}".casefold()
        return all(word.casefold() in text for word in words)


def paths() -> dict[str, Path]:
    """Return the files of the shipped scenarios by name, in the order of family and name."""
    return {path.stem: path for path in sorted(CATALOG.glob("*/*.toml"))}


def entries() -> list[Entry]:
    """Return every shipped scenario with its description."""
    return [_entry(name, path) for name, path in paths().items()]


def chosen(entries: list[Entry], words: Iterable[str], **wanted: str | None) -> list[Entry]:
    """Return the entries that contain all words and have the wanted family, kind or suite; None accepts any.

    Raises
    ------
    InputError
        No entry has that family, kind or suite.
    """
    filters = {name: value for name, value in wanted.items() if value is not None}
    for name, value in filters.items():
        known = sorted({getattr(entry, name) for entry in entries})
        if value not in known:
            raise InputError(f"--{name} {value}: no such {name}; give one of {', '.join(known)}")
    found = [entry for entry in entries if entry.contains(words)]
    return [entry for entry in found if all(getattr(entry, name) == value for name, value in filters.items())]


def study_entries() -> list[Entry]:
    """Return every shipped study; its family is the command that runs it."""
    documents = {path: _document(path) for path in studies().values()}
    return [
        Entry("search" if "search" in document else "sweep", path.stem, document["description"], path=path)
        for path, document in documents.items()
    ]


def studies() -> dict[str, Path]:
    """Return the files of the shipped studies by name."""
    return {path.stem: path for path in sorted(STUDIES.glob("*.toml"))}


def find(name_or_path: str) -> Path:
    """Return the file of a shipped scenario by its name, or of any scenario by its path (ending in .toml).

    Raises
    ------
    ScenarioError
        No scenario of this name ships.
    """
    return find_in(paths(), name_or_path, "scenario", "luxloop list", ScenarioError)


def find_in(files: dict[str, Path], name_or_path: str, kind: str, list_command: str, error: type[InputError]) -> Path:
    """Return one of the shipped files by its name, or any file by its path (ending in .toml).

    Parameters
    ----------
    files
        Shipped files by name.
    name_or_path
        Name or path.
    kind, list_command
        For the message: the kind of file, and the command that lists the names.
    error
        Class of the error raised if no file of this name ships.
    """
    if name_or_path.endswith(".toml"):
        return Path(name_or_path)
    if name_or_path not in files:
        close = get_close_matches(name_or_path, files, n=3, cutoff=0.4)
        hint = f"did you mean {', '.join(close)}?" if close else f"see {list_command}"
        raise error(f"{name_or_path}: no such {kind}; {hint} (a path must end in .toml)")
    return files[name_or_path]


def _entry(name: str, path: Path) -> Entry:
    document = _document(path)
    kind, suite = document["traffic"]["kind"], document.get("suite", "full")
    return Entry(path.parent.name, name, document["description"], kind, suite, document["duration_s"], path)


def _document(path: Path) -> dict[str, Any]:
    return tomllib.loads(path.read_text(encoding="utf-8"))
