"""Reading of input files: devices and pipes are refused, TOML and Parquet have errors on one line. Fast to import."""

import re
import stat
import tomllib
from pathlib import Path
from typing import Any

from luxloop.scenarios.errors import InputError, ScenarioError

CELL_BYTES = 8
"""[bytes] Memory of a cell."""
ALWAYS_BYTES = 2**30
"""[bytes] Tables up to this size are always accepted: constant columns of long runs take hardly any place."""


def require_plain(path: Path) -> None:
    """Raise an InputError for a device, a pipe or a socket, which may be read for ever; a missing file passes."""
    try:
        mode = path.stat().st_mode
    except (OSError, ValueError):
        return
    if not (stat.S_ISREG(mode) or stat.S_ISDIR(mode)):
        raise InputError(f"{path}: is a device or a pipe; give a file")


def open_parquet(path: Path) -> Any:
    """Return the `pyarrow.parquet.ParquetFile` of a path. Equal rows take no place in it: few bytes may be billions.

    Raises
    ------
    InputError
        The path is no file, or expands too much.
    ValueError, OSError
        It is no Parquet file.
    """
    import pyarrow.parquet as pq

    from luxloop.sim.input_files import FACTOR

    require_plain(path)
    file = pq.ParquetFile(path)
    rows, columns = file.metadata.num_rows, file.metadata.num_columns
    if rows * columns * CELL_BYTES > max(ALWAYS_BYTES, FACTOR * path.stat().st_size):
        raise InputError(f"{path}: its {rows} rows expand to more than {FACTOR} times its size; it is damaged")
    return file


def read_parquet(path: Path, columns: list[str] | None = None) -> Any:
    """Return the `pyarrow.Table` of a Parquet file; errors as `open_parquet`."""
    with open_parquet(path) as file:
        return file.read(columns)


_DEEP = re.compile(r"(?<![\w-])(?:[\w-]++\s*+\.\s*+){64}")
"""A dotted key of more than 64 parts; tomllib takes minutes to parse one of thousands."""


def read_toml(path: Path) -> dict[str, Any]:
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
