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
    "tracker.reading": "tracker.hypotheses",
    "tracker.life": "tracker.confirmation",
    "tracker.memory": "tracker.existence",
    "tracker.union": "tracker.merging",
    "tracker.corner.unseen_share": "tracker.corner.unseen_fraction",
    "tracker.association.oddity_max": "tracker.association.shape_cost_max",
}
"""New key of each old one."""

REMOVED = {
    "tracker.body": "the fitted body is gone",
    "tracker.linkage.samples_per_point": "all pairs of near points are hypotheses",
    "tracker.linkage.seed": "all pairs of near points are hypotheses",
    "tracker.merging.speed_change_min_mps": "tracks are not merged by equal motion",
    "tracker.merging.gap_change_max_m": "tracks are not merged by equal motion",
}
"""Reason by old section or key without a successor."""

_NAMES = {
    "tracker/detection/preprocess.py": {
        "tracker.preprocess.own_margin_m": "OWN_MARGIN_M",
    },
    "tracker/detection/deskew.py": {
        "tracker.deskew.margin_m": "MARGIN_M",
    },
    "tracker/free_space.py": {
        "tracker.background.unit_offset_m": "UNIT_OFFSET_M",
        "tracker.boxes.unit_offset_m": "UNIT_OFFSET_M",
        "tracker.existence.unit_offset_m": "UNIT_OFFSET_M",
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
    "tracker/vehicle_classes.py": {
        "tracker.hypotheses.face_min_m": "FACE_MIN_M",
        "tracker.association.birth.speed_max_mps": "FASTEST_MPS",
        "tracker.extent.truncated_probability": "TRUNCATED_PROBABILITY",
        "tracker.extent.large_length_min_m": "CAR_LONGEST_M",
        "tracker.extent.face_min_m": "FACE_MIN_M",
        "tracker.extent.width_max_m": "WIDEST_M",
        "tracker.extent.length_min_m": "WIDE_M",
        "tracker.orientation.width_max_m": "WIDE_M",
        "tracker.orientation.visible_min_m": "FACE_MIN_M",
        "tracker.orientation.truncated_probability": "TRUNCATED_PROBABILITY",
        "tracker.confirmation.truncated_probability": "TRUNCATED_PROBABILITY",
        "tracker.merging.length_max_m": "LONGEST_M",
        "tracker.merging.width_max_m": "WIDEST_M",
    },
    "tracker/tracking/hypotheses.py": {
        "tracker.hypotheses.whole_share": "COMPLETE_FRACTION",
    },
    "tracker/tracking/births.py": {
        "tracker.association.birth.sideways_share": "SIDEWAYS_FRACTION",
        "tracker.association.birth.sideways_m": "SIDEWAYS_M",
        "tracker.association.birth.turn_sigma": "TURN_SIGMA",
        "tracker.association.birth.heading_std_rad": "HEADING_STD_RAD",
        "tracker.association.birth.size_max_m": "SIZE_MAX_M",
        "tracker.association.birth.nearby_m": "NEARBY_M",
        "tracker.association.birth.side_min_m": "SIDE_MIN_M",
    },
    "tracker/tracking/association.py": {
        "tracker.association.gate_probability_min": "GATE_PROBABILITY_MIN",
        "tracker.association.heading_std_rad": "HEADING_STD_RAD",
        "tracker.association.growth_std_m": "GROWTH_STD_M",
    },
    "tracker/tracking/filters.py": {
        "tracker.filters.drift_density_m2ps": "DRIFT_DENSITY_M2PS",
        "tracker.filters.acceleration_time_s": "ACCELERATION_TIME_S",
        "tracker.filters.jerk_time_s": "JERK_TIME_S",
        "tracker.filters.yaw_acceleration_std_radps2": "YAW_ACCELERATION_STD_RADPS2",
        "tracker.filters.yaw_acceleration_time_s": "YAW_ACCELERATION_TIME_S",
        "tracker.filters.starting_speed_std_mps": "STARTING_SPEED_STD_MPS",
        "tracker.filters.manoeuvre_std_mps2": "MANOEUVRE_STD_MPS2",
        "tracker.filters.initial_yaw_rate_std_radps": "INITIAL_YAW_RATE_STD_RADPS",
    },
    "tracker/tracking/heading.py": {
        "tracker.filters.yaw_rate_time_s": "YAW_RATE_TIME_S",
        "tracker.filters.curvature_std_per_m": "CURVATURE_STD_PER_M",
        "tracker.filters.lateral_acceleration_std_mps2": "LATERAL_ACCELERATION_STD_MPS2",
        "tracker.filters.heading_drift_density_rad2ps": "HEADING_DRIFT_DENSITY_RAD2PS",
        "tracker.filters.course_time_s": "COURSE_TIME_S",
        "tracker.filters.slip_std_rad": "SLIP_STD_RAD",
        "tracker.filters.heading_outlier_share": "HEADING_OUTLIER_FRACTION",
        "tracker.filters.heading_restart_s": "HEADING_RESTART_S",
        "tracker.confirmation.heading_gate_sigma": "HEADING_GATE_SIGMA",
        "tracker.confirmation.heading_rejections_max": "HEADING_REJECTIONS_MAX",
        "tracker.orientation.view_correlation": "VIEW_CORRELATION",
    },
    "tracker/tracking/mma.py": {
        "tracker.mma.standing_mps": "STANDING_MPS",
        "tracker.mma.stopping_time_s": "STOPPING_TIME_S",
        "tracker.mma.probability_floor": "PROBABILITY_FLOOR",
    },
    "tracker/tracking/vehicle_size.py": {
        "tracker.extent.hidden_length_m": "HIDDEN_LENGTH_M",
        "tracker.extent.hidden_width_m": "HIDDEN_WIDTH_M",
        "tracker.extent.view_correlation": "VIEW_CORRELATION",
        "tracker.extent.forgetting": "FORGETTING",
        "tracker.extent.merged_probability": "MERGED_PROBABILITY",
        "tracker.extent.growth": "GROWTH",
        "tracker.extent.settled": "SETTLED_GROWTH",
        "tracker.extent.grown_min_m": "GROWN_MIN_M",
        "tracker.extent.known_share": "KNOWN_FRACTION",
    },
    "tracker/tracking/orientation.py": {
        "tracker.orientation.course_speed_min_mps": "COURSE_SPEED_MIN_MPS",
        "tracker.orientation.course_sigma": "COURSE_SIGMA",
        "tracker.orientation.reversal_m": "REVERSAL_M",
        "tracker.orientation.sideways_m": "SIDEWAYS_M",
        "tracker.orientation.turn_log_odds": "TURN_LOG_ODDS",
    },
    "tracker/tracking/traffic_flow.py": {
        "tracker.orientation.flow.ego_log_odds": "EGO_LOG_ODDS",
        "tracker.orientation.flow.neighbour_log_odds": "NEIGHBOUR_LOG_ODDS",
        "tracker.orientation.flow.neighbour_min": "NEIGHBOUR_MIN",
        "tracker.orientation.flow.range_m": "NEIGHBOUR_RANGE_M",
        "tracker.orientation.flow.lane_m": "LANE_STD_M",
    },
    "tracker/tracking/confirmation.py": {
        "tracker.confirmation.view_correlation": "VIEW_CORRELATION",
        "tracker.confirmation.view_log_odds_max": "VIEW_LOG_ODDS_MAX",
        "tracker.confirmation.vehicle_log_odds_max": "VEHICLE_LOG_ODDS_MAX",
        "tracker.confirmation.flat_log_odds": "FLAT_LOG_ODDS",
        "tracker.confirmation.motion_log_odds": "MOTION_LOG_ODDS",
    },
    "tracker/tracking/motion_evidence.py": {
        "tracker.confirmation.moved_views_min": "MOVED_VIEWS_MIN",
    },
    "tracker/tracking/existence.py": {
        "tracker.existence.clutter_per_m2": "CLUTTER_PER_M2",
        "tracker.existence.free_margin_m": "FREE_MARGIN_M",
    },
    "tracker/tracking/small_tracks.py": {
        "tracker.small.longer_max_m": "LENGTH_MAX_M",
        "tracker.small.wider_max_m": "WIDTH_MAX_M",
        "tracker.small.position_std_m": "POSITION_STD_M",
        "tracker.small.acceleration_std_mps2": "ACCELERATION_STD_MPS2",
        "tracker.small.acceleration_time_s": "ACCELERATION_TIME_S",
        "tracker.small.initial_speed_std_mps": "INITIAL_SPEED_STD_MPS",
        "tracker.small.gate": "GATE_CHI2",
        "tracker.small.left_m": "LEFT_M",
        "tracker.small.speed_min_mps": "SPEED_MIN_MPS",
        "tracker.small.straight_min": "STRAIGHT_MIN",
        "tracker.small.confirm_hits": "CONFIRM_HITS",
        "tracker.small.tentative_coast_s": "TENTATIVE_COAST_S",
        "tracker.small.gap_s": "GAP_S",
        "tracker.small.coast_s": "COAST_S",
        "tracker.small.size_gain": "SIZE_GAIN",
        "tracker.small.rider_speed_mps": "RIDER_SPEED_MPS",
        "tracker.small.vehicle_margin_m": "VEHICLE_MARGIN_M",
        "tracker.small.attached_m": "ATTACHED_M",
        "tracker.small.attached_speed_mps": "ATTACHED_SPEED_MPS",
        "tracker.small.whole_views_min": "WHOLE_VIEWS_MIN",
        "tracker.small.same_m": "SAME_M",
    },
    "tracker/merging.py": {
        "tracker.merging.share_min": "MEMBER_FRACTION_MIN",
        "tracker.merging.speed_min_mps": "SPEED_MIN_MPS",
        "tracker.merging.headway_max_s": "HEADWAY_MAX_S",
        "tracker.merging.speed_difference_max_mps": "SPEED_DIFFERENCE_MAX_MPS",
        "tracker.merging.turn_max_rad": "TURN_MAX_RAD",
        "tracker.merging.hits_min": "HITS_MIN",
        "tracker.merging.margin_m": "MARGIN_M",
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
    for removed, reason in REMOVED.items():
        if f"{key}.".startswith(f"{removed}."):
            return f"is not used any more: {reason}; leave it out"
    if key in CONSTANTS:
        constant = CONSTANTS[key]
        return f"is a constant now, {constant.name} in {constant.file}; leave it out"
    if any(name.startswith(f"{key}.") for name in CONSTANTS):
        moved = [f"{old} is {new} now" for old, new in RENAMED.items() if old.startswith(f"{key}.")]
        return "; ".join(["has no settings any more, they are constants; leave it out", *moved])
    return None
