"""Reference of `luxloop.tracker.detection.bowed_faces`, with dense covariances and finite differences."""

import numpy as np

DEPTH_STD, HEADING_STD = 10.0, 0.5 * np.pi / np.sqrt(12.0)


def depths(points, state, side):
    """Depth (2, N) of points behind both faces."""
    heading, depth, curvature, middle = state[0], state[[1, 4]], state[[2, 5]], state[[3, 6]]
    forward, left = np.array([np.cos(heading), np.sin(heading)]), np.array([-np.sin(heading), np.cos(heading)])
    inward, place = side[:, None] * [points @ left, points @ forward], np.array([points @ forward, points @ left])
    return inward - depth[:, None] - curvature[:, None] * (place - middle[:, None]) ** 2


def deviations(ray, heading, shape):
    """Standard deviation (2, N) of the depth on both faces: range noise along the beam, and the rest."""
    normals = np.array([[-np.sin(heading), np.cos(heading)], [np.cos(heading), np.sin(heading)]])
    return np.hypot(shape.range_std * (normals @ ray.T), shape.flatness)


def faces(points, ray, state, side, shape):
    """(N,) face that each point is less deep behind."""
    ratio = depths(points, state, side) / deviations(ray, state[0], shape)
    return np.where(ratio[0] <= ratio[1], 0, 1)


def certainties(depth, std, shape):
    """(N,) weight of each point on its face: its probability of being there, over its variance; 0 for outliers."""
    on_face = (1.0 - shape.inside_share) * np.exp(-0.5 * (depth / std) ** 2)
    inside = np.where(depth > 0.0, shape.inside_share * np.exp(-depth / shape.inside), 0.0)
    outlier = (depth < 0.0) & (0.5 * (depth / std) ** 2 > shape.cost_max)
    return np.where(outlier, 0.0, on_face / np.maximum(on_face + inside, 1e-300) / std**2)


def jacobian(points, face, state, side, step=1e-6):
    """(N, 7) derivatives of each point's depth behind its face, by central differences."""
    columns = []
    for unit in np.eye(len(state)) * step:
        change = depths(points, state + unit, side) - depths(points, state - unit, side)
        columns.append(change[face, np.arange(len(points))] / (2.0 * step))
    return np.stack(columns, axis=1)


def normal_equations(points, ray, line, state, side, prior, scale, shape):
    """Information (7, 7) and gradient (7,) with the covariance of each face's scan lines as one matrix each."""
    face = faces(points, ray, state, side, shape)
    depth = depths(points, state, side)[face, np.arange(len(points))]
    std = scale * deviations(ray, state[0], shape)[face, np.arange(len(points))]
    weight, slopes = certainties(depth, std, shape), jacobian(points, face, state, side)
    information = np.diag([HEADING_STD**-2.0, *2 * [DEPTH_STD**-2.0, 0.0, 0.0]])
    gradient = np.zeros(7)
    for k in range(2):
        for g in np.unique(line):
            on = (face == k) & (line == g) & (weight > 1e-12)
            covariance = np.diag(1.0 / weight[on]) + shape.line_std**2
            information += slopes[on].T @ np.linalg.solve(covariance, slopes[on])
            gradient -= slopes[on].T @ np.linalg.solve(covariance, depth[on])
        for a in range(2):
            at, certainty = 2 + a + 3 * k, prior[k, 2 * a + 1] ** -2.0
            information[at, at] += certainty
            gradient[at] += (prior[k, 2 * a] - state[at]) * certainty
    return information, gradient
