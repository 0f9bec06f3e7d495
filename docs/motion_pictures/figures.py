"""Tables of docs/traffic.md: motion in SUMO and as delivered."""

import numpy as np
from motion_pictures.stage import (
    DT,
    INSTANT,
    SUBLANES,
    TIMED,
    Course,
    Floats,
    Settled,
    delivered_courses,
    on_net,
    on_scenario,
    raw_courses,
)

from luxloop.sim.kinematics import wrap_angle
from luxloop.sim.physical.physical_config import PhysicalConfig

HARD = 10.0
"""[m/s^2] Acceleration that no vehicle reaches."""
CONFIGS = {
    "3.0 s, smoothing 1.2 s": PhysicalConfig(),
    "1.2 s, smoothing 1.2 s": PhysicalConfig(lookahead_s=1.2),
    "0, smoothing 1.2 s": PhysicalConfig(lookahead_s=0.0),
    "0, smoothing 0.4 s": PhysicalConfig(smoothing_s=0.4, lookahead_s=0.0),
}
"""Configurations by look-ahead."""


HEAD = {
    "severity": (
        "traffic",
        "",
        "sideways [m/s]",
        "yaw rate [deg/s]",
        "acceleration [m/s²]",
        "above 10 m/s²",
        "jerk [m/s³]",
    ),
    "deviation": ("traffic", "look-ahead", "largest acceleration [m/s²]", "deviation along [m]", "across [m]"),
}


def tables() -> dict[str, str]:
    """Return both tables as Markdown, by block."""
    runs = {
        "motorway (`sumo-cut-in`), instant lane changes, SUMO's default": on_scenario("sumo-cut-in", INSTANT),
        'the same, `lanechange.duration = "3"`': on_scenario("sumo-cut-in", TIMED),
        'the same, `lateral-resolution = "0.8"`': on_scenario("sumo-cut-in", SUBLANES),
        'crossing (`sumo-crossing`), `lateral-resolution = "0.8"`': on_scenario("sumo-crossing"),
        'winding road (`tests/nets/winding`), `lanechange.duration = "3"`': on_net("winding", TIMED),
        "roundabout (`tests/nets/roundabout`), instant lane changes": on_net("roundabout", INSTANT),
    }
    severity, deviation = [], []
    for name, traffic in runs.items():
        severity.append(f"| {name} | SUMO | {_severity(raw_courses(traffic))} |")
        severity.append(f"| | delivered | {_severity(delivered_courses(traffic.delivered()))} |")
        if "crossing" in name or "roundabout" in name:
            costs = {ahead: _cost(traffic.delivered(config)) for ahead, config in CONFIGS.items()}
            deviation += [f"| {name} | {ahead} | {cost} |" for ahead, cost in costs.items()]
    rows = {"severity": severity, "deviation": deviation}
    return {name: "\n".join([_head(name), *lines]) for name, lines in rows.items()}


def _head(name: str) -> str:
    return f"| {' | '.join(HEAD[name])} |\n{'|---' * len(HEAD[name])}|"


def _severity(courses: list[Course]) -> str:
    """Return largest lateral speed, yaw rate, acceleration (with the count above `HARD`) and jerk, by differences."""
    acceleration, jerk = (np.concatenate([np.hypot(*course.differences(n).T) for course in courses]) for n in (2, 3))
    sideways = max(np.abs(_sideways(course)).max() for course in courses if len(course.time) > 1)
    turn = max(np.abs(wrap_angle(np.diff(course.pose[:, 2]))).max() for course in courses if len(course.time) > 1) / DT
    hard = np.count_nonzero(acceleration > HARD)
    return (
        f"{sideways:.1f} | {np.rad2deg(turn):.0f} | {acceleration.max():.{0 if hard else 1}f} | "
        f"{hard} of {len(acceleration)} | {jerk.max():.0f}"
    )


def _sideways(course: Course) -> Floats:
    """Return the lateral speed (N - 1,) of the box centre [m/s]."""
    yaw, velocity = course.pose[:-1, 2], course.differences(1)
    return np.asarray(velocity[:, 1] * np.cos(yaw) - velocity[:, 0] * np.sin(yaw))


def _cost(settled: Settled) -> str:
    """Return the largest acceleration, and deviations from SUMO: median, 99 % quantile and maximum."""
    acceleration = max(np.hypot(*motion.acceleration_world.T).max() for _, motion in settled)
    kept = np.concatenate([motion.deviation[~motion.changes_lane] for _, motion in settled])
    along, across = np.abs(kept.T)
    return f"{acceleration:.1f} | {_spread(along)} | {_spread(across)}"


def _spread(size: Floats) -> str:
    return f"{np.median(size):.2f}, {np.quantile(size, 0.99):.2f}, {size.max():.1f}"
