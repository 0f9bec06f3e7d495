"""Reading of TOML files, with errors on one line. Fast to import, for the pytest plug-in."""

import re
import tomllib
from pathlib import Path
from typing import Any

from luxloop.scenarios.errors import ScenarioError
from luxloop.scenarios.files.plain_file import require_plain

_DEEP = re.compile(r"(?<![\w-])(?:[\w-]++\s*+\.\s*+){64}")
"""A dotted key of more than 64 parts; tomllib takes minutes to parse one of thousands."""


def read(path: Path) -> dict[str, Any]:
    """Read the document of a scenario file, without validation.

    Raises
    ------
    ScenarioError
        The file does not exist, or is not TOML.
    """
    require_plain(path)
    try:
        text = path.read_text(encoding="utf-8-sig")  # some editors write a byte order mark
        if _DEEP.search(text):
            raise RecursionError
        return tomllib.loads(text)
    except OSError as error:
        raise ScenarioError(f"{path}: {error.strerror}; give a readable file or a name from luxloop list") from error
    except UnicodeDecodeError as error:
        raise ScenarioError(f"{path}: not UTF-8 text at byte {error.start}; save it as UTF-8") from error
    except tomllib.TOMLDecodeError as error:
        raise ScenarioError(f"{path}: not TOML: {error}; correct that line") from error
    except ValueError as error:  # from `int`, for more than 4300 digits
        raise ScenarioError(f"{path}: a number is too long; write at most 18 digits") from error
    except RecursionError as error:
        raise ScenarioError(f"{path}: tables or lists are nested too deeply; remove the innermost") from error
