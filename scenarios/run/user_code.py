"""Import of code of the user by `MODULE:NAME` or `FILE.py:NAME`, with errors of one line."""

import hashlib
import importlib
import importlib.util
import sys
import sysconfig
import traceback
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from types import ModuleType
from typing import Any

from luxloop import former_names

FILE_MODULE = "tracker_file_"
"""Begin of the names of modules that are made of files."""
TEXT_MAX = 4000
"""Longest text of an error."""


class UserCodeError(Exception):
    """The code cannot be imported, or has no such name. One line with file and line."""


def load(spec: str, folder: Path, remedy: str = "name a class with step(scan)") -> Any:
    """Import a class or function; modules may be in `folder`, and relative files are.

    `FILE.py` may import modules of its own folder. Both folders are searched after all installed packages.

    Raises
    ------
    UserCodeError
        See there.
    """
    place, _, name = spec.rpartition(":")
    module = _load_file(folder / place) if place.endswith(".py") else _load_module(place, folder)
    found: Any = getattr(module, name, None)
    if not callable(found):
        problem = "is not callable" if hasattr(module, name) else "is not there"
        raise UserCodeError(f"{name} {problem} in {place}; {remedy}")
    return found


def place_named(module: str) -> str:
    """Return a module, or the file that it was loaded from by `load`, relative to the current folder if it is there."""
    if not module.startswith(FILE_MODULE):
        return module
    file = Path(str(sys.modules[module].__file__))
    return str(file.relative_to(Path.cwd()) if file.is_relative_to(Path.cwd()) else file)


def _load_module(module_name: str, folder: Path) -> ModuleType:
    _search_last(folder)
    try:
        with _one_line_errors():
            return importlib.import_module(module_name)
    except UserCodeError as error:
        cause = error.__cause__
        missing = cause.name if isinstance(cause, ModuleNotFoundError) else None
        if missing is None or not f"{module_name}.".startswith(f"{missing}."):
            raise  # the module exists, and one of its own imports fails
        new_name = former_names.remedy(cause, module_name) if cause else ""
        raise UserCodeError(f"no module {missing} on the Python path or in {folder}{new_name}") from cause


def _load_file(path: Path) -> ModuleType:
    """Import a file under a name that cannot collide with a package; once per process."""
    path = path.resolve()
    name = f"{FILE_MODULE}{path.stem}_{hashlib.blake2b(str(path).encode(), digest_size=4).hexdigest()}"
    if name in sys.modules:
        return sys.modules[name]
    found = importlib.util.spec_from_file_location(name, path)
    assert found is not None
    assert found.loader is not None
    module = importlib.util.module_from_spec(found)
    _search_last(path.parent)
    sys.modules[name] = module  # before it is executed: dataclasses look their module up
    try:
        with _one_line_errors():
            found.loader.exec_module(module)
    except BaseException:
        del sys.modules[name]
        raise
    return module


def _search_last(folder: Path) -> None:
    """Append a folder to the Python path: its modules must not hide installed packages that are imported later."""
    if str(folder) not in sys.path:
        sys.path.append(str(folder))


@contextmanager
def _one_line_errors() -> Iterator[None]:
    """Turn an error while the user's module is imported into one line that names file and line."""
    try:
        yield
    except (Exception, SystemExit, GeneratorExit) as error:
        message = f"{place_of(error)}{reason_of(error)}{former_names.remedy(error)}"
        raise UserCodeError(message) from error


def reason_of(error: BaseException) -> str:
    """Return class and text of an error of the user's code on one line, without the text if its class fails at it."""
    name = type.__dict__["__name__"].__get__(type(error))  # also if a metaclass has a `__name__` of its own
    try:
        text = " ".join(str(error.msg if isinstance(error, SyntaxError) else error)[:TEXT_MAX].split())
    except BaseException:  # its class may do anything
        text = ""
    return f"{name}: {text}".rstrip(": ")


def place_of(error: BaseException, apart_from: tuple[str, ...] = ()) -> str:
    """Return "FILE, line N: " of the user's code that raised an error, empty if no such code was reached.

    `apart_from` are files of the harness.
    """
    if isinstance(error, SyntaxError) and error.filename:
        return f"{error.filename}, line {error.lineno}: "
    libraries = tuple(sysconfig.get_path(name) for name in ("stdlib", "purelib", "platlib"))
    frames = [frame for frame in traceback.extract_tb(error.__traceback__) if not frame.filename.startswith("<")]
    frames = [frame for frame in frames if frame.filename not in (__file__, *apart_from)]
    own = [frame for frame in frames if not frame.filename.startswith(libraries)] or frames
    return f"{own[-1].filename}, line {own[-1].lineno}: " if own else ""
