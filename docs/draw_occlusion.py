"""Copy the figures of occlusion.md from the reports of its studies.

luxloop sweep occlusion               # and the other studies below
python docs/draw_occlusion.py sweeps
"""

import shutil
import sys
from pathlib import Path

from scenarios.study.study_page import PICTURES as FOLDER

PICTURES = {
    "occlusion_survival": "occlusion/01-occlusion_survival",
    "occlusion_reacquire": "occlusion/02-reacquire_s",
    "occlusion_error": "occlusion/03-reappearance_error_m",
    "occlusion_map": "occlusion/04-occlusion_survival",
    "occlusion_partial_switches": "partial-occlusion/01-id_switches",
    "occlusion_partial_heading": "partial-occlusion/05-best_heading_abs_mean_deg",
    "occlusion_partial_fits": "partial-fits/01-best_heading_abs_mean_deg",
    "occlusion_fits": "fits/01-best_heading_abs_mean_deg",
    "occlusion_fits_points": "fits/04-best_heading_abs_mean_deg",
    "occlusion_dropout": "dropout/06-hota",
}
"""Study and figure, by the name in docs/pictures."""


def main() -> None:
    """Copy the figures."""
    sweeps, docs = Path(sys.argv[1]), Path(__file__).parent / "pictures"
    for name, source in PICTURES.items():
        study, _, picture = source.partition("/")
        shutil.copyfile(sweeps / study / FOLDER / f"{picture}.png", docs / f"{name}.png")


if __name__ == "__main__":
    main()
