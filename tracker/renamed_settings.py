"""Settings of earlier versions: their new keys, and those that are constants now."""

from typing import NamedTuple


class Constant(NamedTuple):
    """Constant that was a setting."""

    name: str
    file: str
    """File that defines it, from the root of the repository."""


RENAMED = {
    "tracker.sweep": "tracker.deskew",
    "tracker.ends": "tracker.truncation",
    "tracker.linkage.range_std_m": "tracker.lidar.range_std_m",
    "tracker.linkage.pitch_deg": "tracker.lidar.pitch_deg",
    "tracker.body.range_std_m": "tracker.lidar.range_std_m",
    "tracker.walls.beam_rad": "tracker.lidar.beam_deg",
}
"""New key of each old one."""

_NAMES = {
    "tracker/detection/preprocess.py": {
        "tracker.preprocess.own_margin_m": "OWN_MARGIN_M",
    },
    "tracker/detection/deskew.py": {
        "tracker.deskew.margin_m": "MARGIN_M",
    },
    "tracker/detection/lidar.py": {
        "tracker.background.unit_offset_m": "UNIT_OFFSET_M",
        "tracker.boxes.unit_offset_m": "UNIT_OFFSET_M",
    },
    "tracker/detection/background.py": {
        "tracker.background.cell_m": "CELL_M",
        "tracker.background.share_max": "KNOWN_FRACTION_MAX",
        "tracker.background.hit_log_odds": "HIT_LOG_ODDS",
        "tracker.background.passed_log_odds": "PASSED_LOG_ODDS",
        "tracker.background.log_odds_max": "LOG_ODDS_MAX",
        "tracker.background.log_odds_min": "LOG_ODDS_MIN",
        "tracker.background.interval_s": "PASSED_INTERVAL_S",
        "tracker.background.search_s": "SEARCH_INTERVAL_S",
    },
    "tracker/detection/walls.py": {
        "tracker.walls.length_min_m": "RUN_LENGTH_MIN_M",
        "tracker.walls.half_width_m": "HALF_WIDTH_M",
        "tracker.walls.gap_m": "GAP_M",
    },
    "tracker/detection/truncation.py": {
        "tracker.truncation.nearer_m": "NEARER_M",
    },
    "tracker/detection/tlinkage.py": {
        "tracker.linkage.locality": "LOCALITY",
    },
    "tracker/detection/lines.py": {
        "tracker.linkage.length_min_m": "LENGTH_MIN_M",
        "tracker.linkage.turn_min_deg": "TURN_MIN",
    },
    "tracker/detection/faces.py": {
        "tracker.linkage.flatness_m": "FLATNESS_M",
        "tracker.linkage.gate": "GATE",
        "tracker.linkage.curve_depth_m": "CURVE_DEPTH_M",
        "tracker.linkage.curve_beyond_m": "CURVE_BEYOND_M",
    },
    "tracker/detection/rectangles.py": {
        "tracker.rectangles.step_deg": "STEP_DEG",
    },
    "tracker/detection/alignment.py": {
        "tracker.selection.reach_m": "REACH_M",
        "tracker.selection.flatness_m": "FLATNESS_M",
    },
    "tracker/detection/bowed_faces.py": {
        "tracker.body.flatness_m": "FLATNESS_M",
        "tracker.body.line_std_m": "LINE_STD_M",
        "tracker.body.inside_m": "INSIDE_M",
        "tracker.body.inside_share": "INSIDE_FRACTION",
        "tracker.body.cost_max": "COST_MAX",
        "tracker.body.flank_curvature_per_m": "FLANK_CURVATURE_PER_M",
        "tracker.body.flank_curvature_std_per_m": "FLANK_CURVATURE_STD_PER_M",
        "tracker.body.end_curvature_per_m": "END_CURVATURE_PER_M",
        "tracker.body.end_curvature_std_per_m": "END_CURVATURE_STD_PER_M",
        "tracker.body.flank_length_m": "FLANK_LENGTH_M",
        "tracker.body.end_length_m": "END_LENGTH_M",
        "tracker.body.flank_whole_min_m": "FLANK_WHOLE_MIN_M",
        "tracker.body.end_whole_min_m": "END_WHOLE_MIN_M",
        "tracker.body.flank_middle_std_m": "FLANK_MIDDLE_STD_M",
        "tracker.body.end_middle_std_m": "END_MIDDLE_STD_M",
        "tracker.body.part_middle_std_m": "PART_MIDDLE_STD_M",
        "tracker.body.width_max_m": "WIDTH_MAX_M",
    },
    "tracker/detection/body_fit.py": {
        "tracker.body.alignment_weight": "ALIGNMENT_WEIGHT",
        "tracker.body.temperature": "TEMPERATURE",
        "tracker.body.asymmetry_std_rad": "ASYMMETRY_STD_RAD",
    },
    "tracker/detection/baselines.py": {
        "tracker.baselines.inlier_m": "INLIER_M",
        "tracker.baselines.points_max": "POINTS_MAX",
        "tracker.baselines.seed": "SEED",
    },
    "tracker/detection/boxes.py": {
        "tracker.boxes.noise_std_m": "NOISE_STD_M",
        "tracker.boxes.end_std_m": "END_STD_M",
        "tracker.boxes.depth_min_m": "DEPTH_MIN_M",
        "tracker.boxes.end_view_min_rad": "END_VIEW_MIN_RAD",
        "tracker.boxes.stray_m": "STRAY_M",
        "tracker.boxes.cut_margin_m": "CUT_MARGIN_M",
        "tracker.shadow.depth_m": "PART_DEPTH_M",
        "tracker.shadow.side_min_m": "SINGLE_FACE_MAX_M",
        "tracker.shadow.margin_m": "PART_MARGIN_M",
    },
}
"""Names of the constants that replace old keys, by file and old key."""

CONSTANTS = {key: Constant(name, file) for file, names in _NAMES.items() for key, name in names.items()}
"""Constant that replaces each old key."""


def remedy(key: str) -> str | None:
    """Return what became of an old key; None for a key that never existed.

    Parameters
    ----------
    key
        Key of a scenario file, spelled with dots.
    """
    if key in RENAMED:
        return f"is {RENAMED[key]} now"
    if key in CONSTANTS:
        constant = CONSTANTS[key]
        return f"is a constant now, {constant.name} in {constant.file}; leave it out"
    if any(name.startswith(f"{key}.") for name in CONSTANTS):
        moved = [f"{old} is {new} now" for old, new in RENAMED.items() if old.startswith(f"{key}.")]
        return "; ".join(["has no settings any more, they are constants; leave it out", *moved])
    return None
