"""Digests of source code: of the tracker that a sweep runs, and of the parts of luxloop that determine a result."""

import ast
import hashlib
import importlib.machinery
import shlex
import shutil
import sys
from collections.abc import Iterable, Iterator
from functools import cache
from pathlib import Path

from luxloop.plugins import PluginError
from luxloop.scenarios.run.device import TRACKERS, is_name
from luxloop.scenarios.run.process_tracker import PREFIX
from luxloop.scenarios.study.named_files import digest_of

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
