"""Folders of the KITTI tracking benchmark: the file of their one sequence."""

from pathlib import Path

from luxloop.scenarios.errors import TracksError
from luxloop.scenarios.exchange.file_role import Role

LABELS = ("training/label_02", "label_02", ".")
"""Places of the labels, from the root of a data set, from its part `training`, and in the folder of labels itself."""
RESULTS = "results"
"""Folder of the tracks in exports of luxloop."""
SEQUENCE = "[0-9]*.txt"
"""Names of the files, which are numbers of sequences."""


def is_kitti(folder: Path) -> bool:
    """Return True for a folder with labels or results of sequences."""
    return any(_sequences(folder / place) for place in (*LABELS, RESULTS))


def sequence(folder: Path, role: Role) -> Path:
    """Return the file of labels, or of the results for tracks.

    Raises
    ------
    TracksError
        The folder has none, or several sequences.
    """
    places = LABELS if role == "truth" else (RESULTS, ".")
    found = next((files for place in places if (files := _sequences(folder / place))), [])
    if not found:
        wanted = LABELS[0] if role == "truth" else RESULTS
        raise TracksError(f"{folder}: no {wanted}/0000.txt in it; give the text file of a sequence")
    if len(found) > 1:
        raise TracksError(f"{folder}: has {len(found)} sequences; give the text file of one, e.g. {found[0]}")
    return found[0]


def _sequences(folder: Path) -> list[Path]:
    return sorted(folder.glob(SEQUENCE)) if folder.is_dir() else []
