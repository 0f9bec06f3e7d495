"""Decorator of the kernels that numba compiles."""

import hashlib
import os
import re
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any, TypeVar

from numba import njit

FunctionT = TypeVar("FunctionT", bound=Callable[..., Any])

ROOT = str(Path(__file__).parents[__name__.count(".")])
IMPORT = re.compile(rf"^from ({__package__}[\w.]*) import ([\w, ]*)", re.MULTILINE)
"""Import of a module of the package, or of names of it."""


def kernel(**options: Any) -> Callable[[FunctionT], FunctionT]:
    """Return a decorator that compiles a function by `numba.njit` and caches the result beside the source file.

    `options` are those of `numba.njit`. A wrapper for calls from C is left out: it takes a sixth of the compilation.
    A change of the file, or of a module of luxloop that it imports, makes the cached result invalid.
    """
    settings: dict[str, Any] = {"cache": True, "no_cfunc_wrapper": True, **options}
    decorator: Callable[[FunctionT], FunctionT] = njit(**settings)

    def compiled(function: FunctionT) -> FunctionT:
        dispatcher: Any = decorator(function)
        if hasattr(dispatcher, "_cache"):  # not with NUMBA_DISABLE_JIT
            # numba's own stamp is of this file alone: called kernels and constants in other files would stay old.
            dispatcher._cache._cache_file._source_stamp = _stamp(function.__code__.co_filename)
        return dispatcher  # type: ignore[no-any-return]

    return compiled


@cache
def _stamp(file: str) -> str:
    """Return a digest of a file and of all files that it depends on."""
    return hashlib.blake2b("".join(map(_text, sorted(_sources(file)))).encode()).hexdigest()


@cache
def _sources(file: str) -> frozenset[str]:
    """Return a file, and those of all modules of the package that it imports, directly or not."""
    found = {file}
    for module, names in IMPORT.findall(_text(file)):
        paths = (_path(module), *(_path(f"{module}.{name.strip()}") for name in names.split(",")))
        found.update(*(_sources(path) for path in paths if path))
    return frozenset(found)


@cache
def _path(module: str) -> str | None:
    """Return the file of a module; None for a package or another name."""
    path = f"{ROOT}/{module.replace('.', '/')}.py"
    return path if os.path.isfile(path) else None  # noqa: PTH113


@cache
def _text(file: str) -> str:
    with open(file, encoding="utf-8") as opened:  # noqa: PTH123
        return opened.read()
