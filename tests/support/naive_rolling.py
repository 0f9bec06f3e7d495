"""Axles that follow a front on a given path, integrated in small steps, one body at a time."""

import math


def follow(path, lead, yaw, duration, trailer=None, step=1e-4):
    """Return the final pose of the rear axle (x, y, yaw), and the trailer's yaw, given (kingpin ahead, base, yaw).

    `path(t)` is the front's velocity (vx, vy). The axle does not slip, so the yaw rate is the front's velocity across
    the body over `lead`.
    """
    x, y = -lead * math.cos(yaw), -lead * math.sin(yaw)
    ahead, base, behind = trailer or (0.0, 1.0, yaw)
    for n in range(round(duration / step)):
        vx, vy = path((n + 0.5) * step)
        along = vx * math.cos(yaw) + vy * math.sin(yaw)
        rate = (vy * math.cos(yaw) - vx * math.sin(yaw)) / lead
        kx = along * math.cos(yaw) - ahead * rate * math.sin(yaw)
        ky = along * math.sin(yaw) + ahead * rate * math.cos(yaw)
        behind += step * (ky * math.cos(behind) - kx * math.sin(behind)) / base
        x += step * along * math.cos(yaw)
        y += step * along * math.sin(yaw)
        yaw += step * rate
    return (x, y, yaw), behind
