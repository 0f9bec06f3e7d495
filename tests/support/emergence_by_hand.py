"""Emergence of the target of `behind_parked_truck`, frame by frame from the tables of a run.

Independent of `scenarios.grading`. The target drives along y and the ego along x, so the meeting point has a closed
form.
"""

import math

import shapely
from shapely import affinity

STEP_S = 0.001
"""Step of the time to collision [s]."""


def box(x, y, yaw, length, width):
    upright = shapely.box(-0.5 * length, -0.5 * width, 0.5 * length, 0.5 * width)
    return affinity.translate(affinity.rotate(upright, yaw, origin=(0, 0), use_radians=True), x, y)


def body(row):
    return box(row.x_world_m, row.y_world_m, row.yaw_world_rad, row.length_m, row.width_m)


def overlap(a, b):
    return a.intersection(b).area / a.union(b).area


def is_on(track, target, others):
    """True if a live track that follows no other actor is on the target."""
    if track.status not in ("tentative", "confirmed"):
        return False
    if track.actor_id != -1:
        return track.actor_id == target.actor_id
    shares = {row.actor_id: overlap(body(track), body(row)) for row in [target, *others]}
    if max(shares.values()) >= 0.1:
        return max(shares, key=shares.get) == target.actor_id
    inside = [row for row in [target, *others] if body(track).contains(shapely.Point(row.x_world_m, row.y_world_m))]
    near = min(
        inside,
        key=lambda row: math.hypot(row.x_world_m - track.x_world_m, row.y_world_m - track.y_world_m),
        default=None,
    )
    return near is target


def located(track, target):
    turn = abs(math.remainder(track.yaw_world_rad - target.yaw_world_rad, 2 * math.pi))
    near = math.hypot(track.x_world_m - target.x_world_m, track.y_world_m - target.y_world_m) <= 0.5
    return near and (turn <= math.radians(5.0) or target.kind == "pedestrian")


def time_to_collision(ego, target, longest_s=6.0):
    """Move both boxes in small steps until they touch."""
    dx, dy = target.vx_world_mps - ego.vx_world_mps, target.vy_world_mps - ego.vy_world_mps
    still, moving = body(ego), body(target)
    for step in range(round(longest_s / STEP_S)):
        if still.intersects(affinity.translate(moving, dx * step * STEP_S, dy * step * STEP_S)):
            return step * STEP_S
    return math.inf


def emergence(tables):
    """Return `{stage: None or {measure: value}}` of the target."""
    found = dict.fromkeys(("first_beam", "enough_points", "tentative", "confirmed", "located"))
    by_frame = {frame: list(rows.itertuples()) for frame, rows in tables["tracks"].groupby("frame")}
    actors = {frame: list(rows.itertuples()) for frame, rows in tables["truth"].groupby("frame")}
    beam_s = None
    for ego in tables["ego"].itertuples():
        (target,) = [row for row in actors[ego.frame] if row.name == "target"]
        others = [row for row in actors[ego.frame] if row.name != "target"]
        on = [track for track in by_frame.get(ego.frame, []) if is_on(track, target, others)]
        confirmed = [track for track in on if track.status == "confirmed"]
        beam_s = ego.time_s if beam_s is None and target.points > 0 else beam_s
        if beam_s is None:
            continue  # a box beside may reach over the hidden target
        reached = {
            "first_beam": target.points > 0,
            "enough_points": target.points >= 10,
            "tentative": bool(on),
            "confirmed": bool(confirmed),
            "located": any(located(track, target) for track in confirmed),
        }
        for stage, now in reached.items():
            if now and found[stage] is None:
                found[stage] = situation(ego, target, ego.time_s - beam_s)
    return found


def situation(ego, target, delay_s):
    front_m = ego.x_world_m + 0.5 * ego.length_m
    meeting_m = target.x_world_m - 0.5 * (ego.width_m + target.width_m) - front_m
    return {
        "time_s": ego.time_s,
        "delay_s": delay_s,
        "range_m": math.hypot(target.x_world_m - ego.x_world_m, target.y_world_m - ego.y_world_m),
        "ttc_s": time_to_collision(ego, target),
        "meeting_m": meeting_m,
        "meeting_s": meeting_m / ego.vx_world_mps,
    }
