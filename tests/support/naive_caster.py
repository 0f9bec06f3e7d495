"""Slow and obvious twins of the kernels in `sensor_model.kernels`: every ray against everything, one at a time."""

import math

import numpy as np

_MASK = 0xFFFFFFFF


def ray_ranges(beams, bodies, walls, grow=0.0, chosen=None):
    """(B, A + W + 1) range at which each beam meets each body, each wall and the ground, alone; inf where it does not.

    `grow` moves every plane of the bodies and every edge of the walls outward, and walls to their right [m];
    `chosen` are the beams, all if None.
    """
    chosen = range(len(beams)) if chosen is None else chosen
    ranges = np.full((len(chosen), len(bodies) + len(walls) + 1), math.inf)
    for row, b in zip(ranges, chosen, strict=True):
        origin, direction = beams.origin_ego[beams.unit[b]], beams.direction_ego[b]
        row[: len(bodies)] = [_to_body(origin, direction, bodies, a, grow) for a in range(len(bodies))]
        row[len(bodies) : -1] = [_to_wall(origin, direction, walls, w, grow) for w in range(len(walls))]
        row[-1] = -origin[2] / direction[2] if direction[2] < 0.0 else math.inf
    return ranges


def _to_body(origin, direction, bodies, a, grow):
    x, y, yaw = bodies.pose_ego[a]
    turn = np.array([[math.cos(yaw), math.sin(yaw), 0.0], [-math.sin(yaw), math.cos(yaw), 0.0], [0.0, 0.0, 1.0]])
    start, heading = turn @ (origin - [x, y, 0.0]), turn @ direction
    nearest = math.inf
    for p in range(bodies.body_solid[a], bodies.body_solid[a + 1]):
        planes = bodies.planes[bodies.solid_plane[p] : bodies.solid_plane[p + 1]]
        nearest = min(nearest, _to_solid(start, heading, planes, grow))
    return nearest


def _to_solid(start, heading, planes, grow):
    enter, leave = -math.inf, math.inf
    for plane in planes:
        rate, gap = plane[:3] @ heading, plane[3] + grow - plane[:3] @ start
        if rate < 0.0:
            enter = max(enter, gap / rate)
        elif rate > 0.0:
            leave = min(leave, gap / rate)
        elif gap < 0.0:
            return math.inf
    return enter if 0.0 < enter < leave else math.inf


def _to_wall(origin, direction, walls, w, grow):
    side = walls.ends[w, 2:] - walls.ends[w, :2]
    start = walls.ends[w, :2] - origin[:2] + grow * np.array([side[1], -side[0]]) / np.linalg.norm(side)
    if np.linalg.det([direction[:2], side]) == 0.0:
        return math.inf
    t, along = np.linalg.solve(np.column_stack([direction[:2], -side]), start)
    margin = grow / np.linalg.norm(side)
    on_wall = -margin <= along <= 1.0 + margin and -grow <= origin[2] + t * direction[2] <= walls.height[w] + grow
    return t if t > 0.0 and on_wall else math.inf


def philox4x32(counter, key):
    """Four words of Philox4x32-10, from the definition in Salmon et al. (SC 2011): 64-bit products, halves swapped."""
    c, k = list(counter), list(key)
    for _ in range(10):
        high0, low0 = divmod(0xD2511F53 * c[0], 1 << 32)
        high1, low1 = divmod(0xCD9E8D57 * c[2], 1 << 32)
        c = [high1 ^ c[1] ^ k[0], low1, high0 ^ c[3] ^ k[1], low0]
        k = [(k[0] + 0x9E3779B9) & _MASK, (k[1] + 0xBB67AE85) & _MASK]
    return c
