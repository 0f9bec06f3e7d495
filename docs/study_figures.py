"""Figures of studies, copied from the reports of sweeps into docs/pictures."""

import shutil
from collections.abc import Mapping
from pathlib import Path

from luxloop.scenarios.study.study_page import PICTURES as FOLDER


def copy_figures(pictures: Mapping[str, str], sweeps: Path) -> None:
    """Copy each figure, "study/figure" in the folder `sweeps`, under its name in docs/pictures."""
    docs = Path(__file__).parent / "pictures"
    for name, source in pictures.items():
        study, _, picture = source.partition("/")
        shutil.copyfile(sweeps / study / FOLDER / f"{picture}.png", docs / f"{name}.png")
