"""The folder of a league, which a second start continues."""

from pathlib import Path

from luxloop.scenarios.errors import OutputError
from luxloop.scenarios.league.drive_scans import SCANS
from luxloop.scenarios.league.league_page import DOCUMENT
from luxloop.scenarios.study.row_store import LOCK, ROWS


def refuse_other_files(out: Path) -> None:
    """Raise an OutputError if `out` is a file, or holds other files than those of a league.

    A league that was killed early has a lock file and maybe scans, and nothing else.
    """
    if not out.exists():
        return
    if not out.is_dir():
        raise OutputError(f"{out}: is a file; choose another folder with --out")
    names = {path.name for path in out.iterdir()}
    begun = (out / ROWS).is_file() or (out / DOCUMENT).is_file()
    if not begun and not names <= {SCANS, LOCK}:
        raise OutputError(f"{out}: holds other files than those of a league; choose another folder with --out")
    if (out / SCANS).is_file():
        raise OutputError(f"{out / SCANS}: is a file, but a league has a folder there; choose another with --out")
