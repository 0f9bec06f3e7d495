"""Slow reference implementations of the grader's array operations."""

import cmath
import math
from itertools import permutations

import numpy as np


def corners(box):
    """Corners of a box (x, y, yaw, length, width) as complex numbers, counter-clockwise."""
    x, y, yaw, length, width = box
    signs = [(1, 1), (-1, 1), (-1, -1), (1, -1)]
    return [complex(x, y) + complex(sx * length / 2, sy * width / 2) * cmath.exp(1j * yaw) for sx, sy in signs]


def cross(a, b):
    return a.real * b.imag - a.imag * b.real


def area(polygon):
    return 0.5 * sum(cross(p, q) for p, q in zip(polygon, polygon[1:] + polygon[:1], strict=True))


def clip(polygon, start, end):
    """Clip a polygon to the left of the line from start to end (Sutherland and Hodgman 1974)."""
    out = []
    for p, q in zip(polygon, polygon[1:] + polygon[:1], strict=True):
        left_p, left_q = cross(end - start, p - start), cross(end - start, q - start)
        if left_p >= 0:
            out.append(p)
        if (left_p > 0 > left_q) or (left_p < 0 < left_q):
            out.append(p + (q - p) * left_p / (left_p - left_q))
    return out


def iou(a, b):
    shared = corners(a)
    frame = corners(b)
    for start, end in zip(frame, frame[1:] + frame[:1], strict=True):
        shared = clip(shared, start, end) if shared else []
    inside = area(shared) if shared else 0.0
    return inside / (a[3] * a[4] + b[3] * b[4] - inside)


def best_pairing(score):
    """Pairs (row, column) of the largest total score, by exhaustive search; pairs with score 0 are left out."""
    rows, columns = score.shape
    if rows > columns:
        return sorted((row, column) for column, row in best_pairing(score.T))
    best = max(permutations(range(columns), rows), key=lambda p: sum(score[r, c] for r, c in enumerate(p)))
    return [(r, c) for r, c in enumerate(best) if score[r, c] > 0]


def counts(point_actor, label, actor_id, segment_count):
    """Points of each actor in each segment; the last row counts points on no actor."""
    table = np.zeros((len(actor_id) + 1, segment_count), dtype=np.int64)
    ids = list(actor_id)
    for actor, segment in zip(point_actor, label, strict=True):
        if segment >= 0:
            table[ids.index(actor) if actor in ids else len(ids), segment] += 1
    return table


def ranges(heading, offsets, beams):
    """Range of each beam (origin, unit vector, normal of its face at heading 0, face) to a vehicle of this heading."""
    found = []
    for origin, direction, normal, face in beams:
        out = normal * cmath.exp(1j * heading)
        found.append((offsets[face] - dot(out, origin)) / dot(out, direction))
    return np.array(found)


def dot(a, b):
    return a.real * b.real + a.imag * b.imag


def heading_bound(heading, offsets, beams, sigma):
    """Cramer-Rao bound from the full Fisher matrix of heading and offsets, with numerical derivatives."""
    faces = sorted({face for *_, face in beams})
    unknown = np.array([heading, *(offsets[face] for face in faces)])

    def predicted(values):
        return ranges(values[0], dict(zip(faces, values[1:], strict=True)), beams)

    step = 1e-5
    jacobian = np.column_stack(
        [(predicted(unknown + step * e) - predicted(unknown - step * e)) / (2 * step) for e in np.eye(len(unknown))]
    )
    return math.sqrt(np.linalg.inv(jacobian.T @ jacobian / sigma**2)[0, 0])


def most_likely_heading(measured, heading, offsets, beams, rounds=4):
    """Maximum likelihood heading of the measured ranges, by Gauss-Newton iterations from the truth."""
    faces = sorted({face for *_, face in beams})
    unknown, step = np.array([heading, *(offsets[face] for face in faces)]), 1e-5

    def predicted(values):
        return ranges(values[0], dict(zip(faces, values[1:], strict=True)), beams)

    for _ in range(rounds):
        jacobian = np.column_stack(
            [(predicted(unknown + step * e) - predicted(unknown - step * e)) / (2 * step) for e in np.eye(len(unknown))]
        )
        unknown += np.linalg.lstsq(jacobian, measured - predicted(unknown), rcond=None)[0]
    return unknown[0]


def resampled(bootstrap, vehicle, values):
    """Mean and standard deviation of each resample of a bootstrap, with its observations collected one by one."""
    means, stds = [], []
    for times in bootstrap.times:
        drawn = [
            value
            for known, count in zip(bootstrap.vehicles, times, strict=True)
            for value in values[vehicle == known].tolist() * int(count)
        ]
        means.append(np.mean(drawn))
        stds.append(np.std(drawn))
    return means, stds
