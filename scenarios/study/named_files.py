"""Files that a scenario names: rig, units, nets, routes, SUMO configurations, recordings; and those named in them."""

import hashlib
import re
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any

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
