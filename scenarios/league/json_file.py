"""Atomic write of a JSON file in the folder of a league."""

import json
from pathlib import Path

from luxloop.scenarios.errors import OutputError
from luxloop.scenarios.files import atomic_file


def write_json(path: Path, content: object) -> None:
    """Write a file atomically.

    Raises
    ------
    OutputError
        It cannot be written.
    """
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with atomic_file.create(path) as temporary:
            temporary.write_text(json.dumps(content, indent=1, allow_nan=False) + "\n", encoding="utf-8")
    except OSError as error:
        raise OutputError(f"{path}: cannot write there ({error.strerror}); choose another folder with --out") from error
