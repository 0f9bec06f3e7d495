"""Copy the figures of emergence.md from the reports of its studies.

luxloop sweep parked-truck --seeds 11-13   # and the other studies on the page
python docs/draw_emergence.py sweeps
"""

import sys
from pathlib import Path

from study_figures import copy_figures

PICTURES = {
    "emergence_truck_points": "parked-truck/01-target_enough_points_meeting_m",
    "emergence_truck": "parked-truck/02-target_confirmed_meeting_m",
    "emergence_truck_time": "parked-truck/03-target_confirmed_meeting_s",
    "emergence_house": "side-street/01-target_confirmed_meeting_m",
    "emergence_bus": "turning-bus/01-target_confirmed_meeting_m",
    "emergence_cut_in": "cut-in/01-target_confirmed_meeting_m",
}
"""Study and figure, by the name in docs/pictures."""

if __name__ == "__main__":
    copy_figures(PICTURES, Path(sys.argv[1]))
