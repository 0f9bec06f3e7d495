"""Content that a run depends on besides its parameters: files, source code and versions. Rows are reused by content."""

import ast
import hashlib
import importlib.machinery
import json
import re
import shlex
import shutil
import sys
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

from luxloop.plugins import PluginError
from luxloop.scenarios.run.device import TRACKERS, is_name
from luxloop.scenarios.run.process_tracker import PREFIX
from luxloop.scenarios.run.versions import installed

ROOT = Path(__file__).parents[2]
"""Folder of the package."""
SIMULATION = ("sim", "sensor_model", "scenarios/grading", "scenarios/run", "scenarios/control")
"""Folders of luxloop whose code and data determine a result, beside the tracker."""
SUFFIXES = (".py", ".toml")


def of_simulation() -> str:
    """Return the digest of traffic, sensor, run loop and grading, with the shipped rigs and units."""
    return of_folders(*SIMULATION)


def of_folders(*folders: str) -> str:
    """Return the digest of the code and data in folders of luxloop."""
    return _combined(path for folder in folders for path in _sources(ROOT / folder))


def of_tracker(spec: str) -> str:
    """Return the digest of a tracker's source; empty if it is not found, which `device.load` reports.

    - `NAME` of a plug-in: as its `MODULE:NAME`.
    - `process:COMMAND`: the program, and all arguments that are files, with the local modules of Python files.
    - `FILE.py:NAME`: the file and the local modules that it imports, at any depth.
    - `MODULE:NAME`: the whole top-level package, or the module as a file; of luxloop's own, the package below it.
    """
    if spec.startswith(PREFIX):
        return _combined(_files_of_command(spec.removeprefix(PREFIX)))
    if is_name(spec):
        try:
            spec = TRACKERS.place(spec) if spec in TRACKERS.names() else spec
        except PluginError:
            return ""
    place = spec.rpartition(":")[0]
    if not place:
        return ""
    if place.endswith(".py"):
        return _combined(_imported(Path(place)))
    package, _, module = place.partition(".")
    if package == "luxloop":
        return of_folders(module.partition(".")[0])
    found = importlib.machinery.PathFinder.find_spec(package, [*sys.path, str(Path.cwd())])
    if found is None or found.origin is None:
        return ""
    origin = Path(found.origin)
    return _combined(_sources(origin.parent) if origin.name == "__init__.py" else _imported(origin))


def _sources(folder: Path) -> Iterator[Path]:
    """Yield the source files in a folder, at any depth."""
    yield from (path for path in folder.rglob("*") if path.suffix in SUFFIXES)


def _imported(file: Path) -> set[Path]:
    """Return a file and the modules in its folder that it imports, directly or in such a module."""
    found, waiting = set[Path](), [file.absolute()]
    while waiting:
        path = waiting.pop()
        if path in found or not path.is_file():
            continue
        found.add(path)
        for name in _imports(path, path.stat().st_mtime_ns):
            local = file.absolute().parent.joinpath(*name.split("."))
            waiting += [local.with_suffix(".py"), local / "__init__.py", local.parent.with_suffix(".py")]
    return found


@cache
def _imports(path: Path, _changed_ns: int) -> tuple[str, ...]:
    """Return the names of the modules that a file may import: `a.b` for `import a.b`, `a` and `a.b` for `from a`."""
    try:
        tree = ast.parse(path.read_bytes())
    except (SyntaxError, ValueError):
        return ()
    names: list[str] = []
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            names += [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            base = node.module or ""
            names += [base, *(f"{base}.{alias.name}".lstrip(".") for alias in node.names)]
    return tuple(name for name in names if name)


def _files_of_command(command: str) -> Iterator[Path]:
    program, *arguments = shlex.split(command)
    for word in (shutil.which(program) or program, *arguments):
        path = Path(word)
        if path.is_file():
            yield from _imported(path) if path.suffix == ".py" else [path]


def _combined(paths: Iterable[Path]) -> str:
    """Return one digest of the names and the content of files, independent of their folder."""
    digests = sorted(f"{path.name} {digest_of(path)}" for path in paths)
    return hashlib.blake2b("\n".join(digests).encode(), digest_size=12).hexdigest() if digests else ""


_QUOTED = re.compile(rb"""["']([^"'<>\r\n]{1,1000}\.[A-Za-z]{2,8})["']""")
"""A quoted text that ends like the name of a file."""
_SEPARATOR = re.compile(r"[,;\s]+")
_READ_FOR_NAMES = (".toml", ".xml", ".sumocfg")
_WITHOUT_NAMES = (".net.xml",)
"""Large files that name no others."""

Digests = tuple[tuple[str, str], ...]
"""Path as written in the scenario (or in the file that names it) and digest of the content, sorted by path."""


def named_files(document: dict[str, Any], folder: Path) -> Digests:
    """Return the digests of all files that a scenario names, directly or in a file that it names.

    Every text in the scenario, and every quoted text in such a file, counts if it is the path of an existing file,
    relative to the scenario or to that file. Lists in one text may be separated by commas or spaces, as in SUMO.

    Parameters
    ----------
    document
        Content of the scenario file.
    folder
        Folder that relative paths in it start from.
    """
    found: dict[Path, str] = {}
    for path, name in _existing(_texts(document), folder):
        _add(found, path, name)
    return tuple(sorted((name, digest_of(path)) for path, name in found.items()))


def digest_of(path: Path) -> str:
    """Return the digest of a file's content; cached until its size or time of change differs."""
    return _content(path, *_state(path))[0]


def _add(found: dict[Path, str], path: Path, name: str) -> None:
    """Add a file and those that it names."""
    if path.resolve() in found:
        return
    found[path.resolve()] = name
    for inner, inner_name in _existing(_content(path, *_state(path))[1], path.parent):
        _add(found, inner, inner_name)


def _existing(texts: Iterator[str] | tuple[str, ...], folder: Path) -> Iterator[tuple[Path, str]]:
    """Yield the path and the text of every text that names an existing file; of a list, every such part."""
    for text in texts:
        if _is_file(folder / text):
            yield folder / text, text
            continue
        for part in _SEPARATOR.split(text):
            if part and part != text and _is_file(folder / part):
                yield folder / part, part


def _texts(value: Any) -> Iterator[str]:
    """Yield every text in a document that may name a file: those with a dot or a slash, at any depth."""
    if isinstance(value, dict):
        for item in value.values():
            yield from _texts(item)
    elif isinstance(value, list | tuple):
        for item in value:
            yield from _texts(item)
    elif isinstance(value, str) and ("." in value or "/" in value):
        yield value


def _state(path: Path) -> tuple[int, int]:
    state = path.stat()
    return state.st_mtime_ns, state.st_size


@cache
def _content(path: Path, _changed_ns: int, _size: int) -> tuple[str, tuple[str, ...]]:
    """Return the digest of a file and the texts in it that look like names of files."""
    data = path.read_bytes()
    digest = hashlib.blake2b(data, digest_size=12).hexdigest()
    if not path.name.endswith(_READ_FOR_NAMES) or path.name.endswith(_WITHOUT_NAMES):
        return digest, ()
    return digest, tuple(dict.fromkeys(text.decode("utf-8", "replace") for text in _QUOTED.findall(data)))


def _is_file(path: Path) -> bool:
    try:
        return path.is_file()
    except (OSError, ValueError):  # a text that is too long for a path, or has a zero byte
        return False


Json = dict[str, Any]


@dataclass(frozen=True, slots=True)
class RunContent:
    """Digests of everything outside the scenario that determines the result of a run."""

    files: Digests
    """Files that the scenario names."""
    tracker: str
    """Source code of the tracker."""
    simulation: str
    """Source code of luxloop without the tracker."""
    versions: tuple[tuple[str, str], ...]
    """Installed packages."""


class Contents:
    """Content of the runs of one tracker; runs with the same files share one object.

    Source code is read once, when this object is made.

    Parameters
    ----------
    tracker
        MODULE:NAME, FILE.py:NAME or process:COMMAND of the device under test.
    """

    def __init__(self, tracker: str) -> None:
        self._tracker = of_tracker(tracker)
        self._simulation = of_simulation()
        self._versions = tuple(sorted(installed().items()))
        self._known: dict[Digests, RunContent] = {}

    def of(self, document: Json, folder: Path) -> RunContent:
        """Return the content of a scenario's run; relative paths in the scenario start from a folder."""
        files = (*named_files(document, folder), *_functions(document))
        if files not in self._known:
            self._known[files] = RunContent(files, self._tracker, self._simulation, self._versions)
        return self._known[files]


def _functions(document: Json) -> Digests:
    """Return the digests of the source of the functions in `[[metric]]` tables, which `MODULE:FUNCTION` names."""
    functions = [metric["function"] for metric in document.get("metric", []) if metric.get("function")]
    return tuple((name, of_tracker(name)) for name in dict.fromkeys(functions))


def inputs(document: Json, content: RunContent) -> Json:
    """Return the digests of all inputs of a run, as stored in its row."""
    return {
        "scenario": digest(document),
        "files": dict(content.files),
        "tracker": content.tracker,
        "luxloop": content.simulation,
        "versions": dict(content.versions),
    }


def digest(value: Any) -> str:
    """Return the digest of a JSON value."""
    return hashlib.blake2b(json.dumps(value, sort_keys=True, default=str).encode(), digest_size=12).hexdigest()


def changes(before: Json, now: Json) -> list[str]:
    """Return a text for each difference between the inputs of two runs: changed files, source code and versions."""
    words = {"scenario": "the scenario", "tracker": "the tracker's source", "luxloop": "luxloop's source"}
    found = [f"{word} changed" for key, word in words.items() if before.get(key) != now[key]]
    for name in sorted({*before.get("files", {}), *now["files"]}):
        was, is_now = before.get("files", {}).get(name), now["files"].get(name)
        if was != is_now:
            found.append(f"{name} {'changed' if was and is_now else 'is new' if is_now else 'is gone'}")
    for name in sorted({*before.get("versions", {}), *now["versions"]}):
        was, is_now = before.get("versions", {}).get(name), now["versions"].get(name)
        if was != is_now:
            found.append(f"{name} {was or 'missing'} became {is_now or 'missing'}")
    return found
