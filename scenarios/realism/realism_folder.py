"""Folder of a comparison with real vehicles: table, JSON, figures and matched vehicles."""

import json
from pathlib import Path

from luxloop.scenarios.errors import OutputError
from luxloop.scenarios.files import atomic_folder
from luxloop.scenarios.realism import realism_figures, realism_table
from luxloop.scenarios.realism.realism_comparison import Comparison
from luxloop.scenarios.report import text

DOCUMENT, TABLE, MATCHED = "realism.json", "realism.txt", "matched.csv"
FIGURE_FORMAT = "%.6g"
OPTION = "--out"


def write(comparison: Comparison, out: Path) -> None:
    """Write the folder atomically; an earlier one of the same kind is replaced.

    Raises
    ------
    OutputError
        The folder cannot be written, or holds other files.
    """
    with atomic_folder.create(out, OPTION, refuse_other_files) as folder:
        try:
            document = realism_table.document(comparison)
            (folder / DOCUMENT).write_text(json.dumps(document, indent=2, allow_nan=False) + "\n", encoding="utf-8")
            (folder / TABLE).write_text(text.as_text(realism_table.report(comparison)), encoding="utf-8")
            comparison.matched.to_csv(folder / MATCHED, index=False, float_format=FIGURE_FORMAT)
            realism_figures.save(comparison, folder)
        except OSError as error:
            raise atomic_folder.cannot_write(out, OPTION, error) from error


def refuse_other_files(out: Path) -> None:
    """Check that `out` is new, or an earlier comparison.

    Raises
    ------
    OutputError
        It holds other files.
    """
    if out.exists() and not (out / DOCUMENT).is_file():
        raise OutputError(f"{out}: already exists and holds no earlier comparison; choose another folder with {OPTION}")
