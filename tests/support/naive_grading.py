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


def dot(a, b):
    return a.real * b.real + a.imag * b.imag


class BowedFaces:
    """Heading, offsets and sagittas of faces as one vector, and the ranges that they predict.

    `shapes` gives the half width and the middle of each face, and the spread of its sagitta.
    """

    def __init__(self, beams, shapes):
        self.shapes = shapes
        self.origin, self.direction, self.normal = (np.array([beam[k] for beam in beams]) for k in range(3))
        self.faces = sorted({face for *_, face in beams})
        self.face = np.array([self.faces.index(face) for *_, face in beams])
        self.half, self.middle = (np.array([shapes[face][k] for *_, face in beams]) for k in range(2))

    def vector(self, heading, offsets, sagittas):
        return np.array([heading, *(offsets[face] for face in self.faces), *(sagittas[face] for face in self.faces)])

    def predicted(self, values):
        """Range of each beam to the parabola out . x = offset - sagitta (t / half)^2, by Newton's method."""
        offsets, sagittas = np.split(values[1:], 2)
        offset, sagitta = offsets[self.face], sagittas[self.face]
        out = self.normal * cmath.exp(1j * values[0])
        reach = (offset - dot(out, self.origin)) / dot(out, self.direction)
        for _ in range(3):
            x = self.origin + reach * self.direction
            t = dot(out * 1j, x - self.middle)
            behind = dot(out, x) - offset + sagitta * (t / self.half) ** 2
            slope = dot(out, self.direction) + 2 * sagitta * t * dot(out * 1j, self.direction) / self.half**2
            reach = reach - behind / slope
        return reach

    def jacobian(self, values, step=1e-5):
        each = step * np.eye(len(values))
        return np.column_stack([(self.predicted(values + e) - self.predicted(values - e)) / (2 * step) for e in each])

    def prior(self):
        """Square root of the information of the prior: a row per sagitta."""
        rows = np.zeros((len(self.faces), 1 + 2 * len(self.faces)))
        for k, face in enumerate(self.faces):
            rows[k, 1 + len(self.faces) + k] = 1.0 / self.shapes[face][2]
        return rows

    def heading_bound(self, values, sigma):
        """Hybrid Cramer-Rao bound from the full information matrix, with numerical derivatives."""
        rows = np.vstack([self.jacobian(values) / sigma, self.prior()])
        return math.sqrt(np.linalg.inv(rows.T @ rows)[0, 0])

    def most_likely_heading(self, measured, start, sigma, rounds=3):
        """Heading of the largest posterior density, by Gauss-Newton iterations."""
        prior, values = self.prior(), start.copy()
        for _ in range(rounds):
            rows = np.vstack([self.jacobian(values) / sigma, prior])
            residual = np.concatenate([(measured - self.predicted(values)) / sigma, -prior @ values])
            values = values + np.linalg.lstsq(rows, residual, rcond=None)[0]
        return values[0]
