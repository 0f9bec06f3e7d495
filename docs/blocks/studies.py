"""Figures of studies, from the reports of their sweeps."""

import shutil
from pathlib import Path

import pandas as pd
from blocks import commands
from blocks.markdown import markdown

from luxloop.scenarios.study.study_page import PICTURES as FOLDER

PICTURES = Path(__file__).parents[1] / "pictures"
FIGURES = {
    "occlusion_survival": "occlusion/01-occlusion_survival",
    "emergence_truck": "parked-truck/02-meeting_m{stage=confirmed}",
}
"""Study and figure, by the name in docs/pictures."""
SURVIVAL, CONFIRMED = "track.occlusion_survival", "emergence.meeting_m{stage=confirmed}"
EMERGENCE = {"parked-truck": "who", "side-street": "ego_mps", "turning-bus": "ego_mps", "cut-in": "occluder"}
"""Parameter by which the rows of each study are grouped."""


def command(name: str) -> str:
    """Return the sweep that draws a figure."""
    return sweep(FIGURES[name].partition("/")[0])


def sweep(study: str) -> str:
    """Return the command of a study, with seeds on which nothing was chosen."""
    return f"luxloop sweep {study} --seeds 11-16"


def picture(name: str) -> None:
    """Copy a figure from the report of its sweep; the sweep resumes where it was."""
    commands.output(command(name))
    study, _, figure = FIGURES[name].partition("/")
    shutil.copyfile(commands.SWEEPS / study / FOLDER / f"{figure}.png", PICTURES / f"{name}.png")


def runs(study: str) -> pd.DataFrame:
    """Return the rows of a sweep."""
    commands.output(sweep(study))
    return pd.read_parquet(commands.SWEEPS / study / "runs.parquet")


def survival(_name: str) -> str:
    """Return the ids that survive a complete occlusion, by time hidden and speed."""
    known = runs("occlusion").dropna(subset=[SURVIVAL])
    table = known.pivot_table(index="occlusion_s", columns="speed_mps", values=SURVIVAL, aggfunc=["sum", "count"])
    head = ("hidden [s]", *(f"{speed:g} m/s" for speed in table["sum"].columns))
    rows = (
        (f"{time:g}", *(f"{kept:g} of {count:g}" for kept, count in zip(row["sum"], row["count"], strict=True)))
        for time, row in table.iterrows()
    )
    return markdown(head, rows)


def emergence(_name: str) -> str:
    """Return how many targets are confirmed before the meeting point, and how far away the ego is then."""
    rows = []
    for study, by in EMERGENCE.items():
        for value, group in runs(study).groupby(by):
            found = group[CONFIRMED].dropna()
            far = f"{found.median():.1f}" if len(found) else "never"
            rows.append((f"{study}, {value}", f"{len(found)} of {len(group)}", far))
    return markdown(("study", "confirmed", "median distance then [m]"), rows)
