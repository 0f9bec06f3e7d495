"""TOML from people's hands. Light to import: pytest's plug-in reads with it wherever luxloop is installed."""

import re
import tomllib
from pathlib import Path
from typing import Any

from scenarios.errors import ScenarioError

_DEEP = re.compile(r"(?<![\w-])(?:[\w-]++\s*+\.\s*+){64}")
"""A dotted key of more parts than anybody writes; tomllib takes minutes over thousands."""


def read(path: Path) -> dict[str, Any]:
    """Read a scenario file, whatever is in it.

    Raises
    ------
    ScenarioError
        There is no such file, or it is not TOML.
    """
    try:
        text = path.read_text(encoding="utf-8-sig")  # some editors begin a file with a byte order mark
        if _DEEP.search(text):
            raise RecursionError
        return tomllib.loads(text)
    except OSError as error:
        raise ScenarioError(f"{path}: {error.strerror}; give a readable file or a name from luxloop list") from error
    except UnicodeDecodeError as error:
        raise ScenarioError(f"{path}: not UTF-8 text at byte {error.start}; save it as UTF-8") from error
    except tomllib.TOMLDecodeError as error:
        raise ScenarioError(f"{path}: not TOML: {error}; correct that line") from error
    except ValueError as error:  # of Python's own int, from thousands of digits on
        raise ScenarioError(f"{path}: a number in it is too long; write one of at most 18 digits") from error
    except RecursionError as error:
        raise ScenarioError(f"{path}: tables or lists in it are nested too deeply; take the innermost out") from error
