"""Copy the figures of occlusion.md from the reports of its studies.

luxloop sweep occlusion               # and the other studies below
python docs/draw_occlusion.py sweeps
"""

import sys
from pathlib import Path

from study_figures import copy_figures

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
    "occlusion_occluders": "occluders/03-best_heading_abs_mean_deg",
    "occlusion_failed_unit": "failed-unit/01-occlusion_survival",
    "occlusion_dropout": "dropout/06-hota",
}
"""Study and figure, by the name in docs/pictures."""

if __name__ == "__main__":
    copy_figures(PICTURES, Path(sys.argv[1]))
