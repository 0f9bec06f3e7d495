"""Figures of studies, from the reports of their sweeps."""

import shutil
from pathlib import Path

from blocks import commands

from luxloop.scenarios.study.study_page import PICTURES as FOLDER

PICTURES = Path(__file__).parents[1] / "pictures"
FIGURES = {
    "occlusion_survival": "occlusion/01-occlusion_survival",
    "occlusion_reacquire": "occlusion/02-reacquire_s",
    "occlusion_error": "occlusion/03-reappearance_error_m",
    "occlusion_map": "occlusion/04-occlusion_survival",
    "occlusion_partial_switches": "partial-occlusion/01-id_switches",
    "occlusion_partial_heading": "partial-occlusion/05-best_heading_abs_mean_deg",
    "occlusion_partial_fits": "partial-fits/01-best_heading_abs_mean_deg",
    "occlusion_fits": "fits/01-best_heading_abs_mean_deg",
    "occlusion_fits_points": "fits/04-best_heading_abs_mean_deg",
    "occlusion_occluders": "occluders/03-best_heading_abs_mean_deg",
    "occlusion_failed_unit": "failed-unit/01-occlusion_survival",
    "occlusion_dropout": "dropout/06-hota",
    "emergence_truck_points": "parked-truck/01-target_enough_points_meeting_m",
    "emergence_truck": "parked-truck/02-target_confirmed_meeting_m",
    "emergence_truck_time": "parked-truck/03-target_confirmed_meeting_s",
    "emergence_house": "side-street/01-target_confirmed_meeting_m",
    "emergence_bus": "turning-bus/01-target_confirmed_meeting_m",
    "emergence_cut_in": "cut-in/01-target_confirmed_meeting_m",
}
"""Study and figure, by the name in docs/pictures."""


def command(name: str) -> str:
    """Return the sweep that draws a figure, with seeds on which nothing was chosen."""
    return f"luxloop sweep {FIGURES[name].partition('/')[0]} --seeds 11-16"


def picture(name: str) -> None:
    """Copy a figure from the report of its sweep; the sweep resumes where it was."""
    commands.output(command(name))
    study, _, figure = FIGURES[name].partition("/")
    shutil.copyfile(commands.SWEEPS / study / FOLDER / f"{figure}.png", PICTURES / f"{name}.png")
