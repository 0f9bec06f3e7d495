"""Slow, obvious twins of `tracker.kernels`: every pair, every matrix, numpy where the kernel has a loop."""

import numpy as np


def connected(points, radius):
    """Lowest index of each point's chain, by flooding over all pairs."""
    distance = np.linalg.norm(points[:, None] - points[None], axis=2)
    joined = distance <= np.maximum(radius[:, None], radius[None])
    root = np.full(len(points), -1)
    for start in range(len(points)):
        todo = [start] if root[start] < 0 else []
        while todo:
            i = todo.pop()
            root[i] = start
            todo += [j for j in np.flatnonzero(joined[i]) if root[j] < 0]
    return root


def hypotheses(points, uniforms, locality):
    """(K, N) partner of each point and draw, -1 for none."""
    reach = locality * np.linalg.norm(np.ptp(points, axis=0))
    partner = np.full((uniforms.shape[1], len(points)), -1)
    for i, point in enumerate(points):
        squared = np.sum((points - point) ** 2, axis=1)
        weight = np.where(squared > 0, np.exp(-squared / max(reach, 1e-300) ** 2), 0.0)
        if weight.sum() > 0:
            for k in range(uniforms.shape[1]):
                partner[k, i] = np.flatnonzero(np.cumsum(weight) > uniforms[i, k] * weight.sum())[0]
    return partner


def preferences(points, lines, tau):
    """Equation (1), (M, N)."""
    distance = np.abs(lines[:, :2] @ points.T + lines[:, 2:])
    return np.where(distance < tau, np.exp(-distance / tau), 0.0)


def tanimoto(p, q):
    """Equation (2)."""
    product = np.dot(p, q)
    return 1.0 - product / (np.dot(p, p) + np.dot(q, q) - product) if product > 0 else 1.0


def agglomerate(table):
    """Algorithm 1 to the letter: search all pairs for the least distance, merge, start again."""
    clusters = {i: [i] for i in range(table.shape[1])}
    preference = {i: table[:, i] for i in clusters}
    while True:
        pairs = [(tanimoto(preference[p], preference[q]), p, q) for p in clusters for q in clusters if p < q]
        distance, p, q = min(pairs, default=(1.0, -1, -1))
        if distance >= 1.0:
            return {frozenset(members) for members in clusters.values()}
        clusters[p] += clusters.pop(q)
        preference[p] = np.minimum(preference[p], preference.pop(q))


def fit_line(points):
    """Total least squares by singular values: unit normal and offset."""
    mean = points.mean(axis=0)
    normal = np.linalg.svd(points - mean)[2][-1]
    return np.append(normal, -normal @ mean)


def assign(points, lines, tau):
    """Nearest line within tau of each point, or -1."""
    distance = np.abs(points @ lines[:, :2].T + lines[:, 2])
    return np.where(distance.min(axis=1) < tau, distance.argmin(axis=1), -1)


def nearer_side(projection):
    """Distances to the edge, lower or upper, that has them smaller in norm (Zhang 2017)."""
    below, above = projection - projection.min(), projection.max() - projection
    return above if np.linalg.norm(above) <= np.linalg.norm(below) else below


def criteria(points, angle, floor):
    """Area, closeness and variance of a heading (Zhang 2017, algorithms 3 to 5)."""
    c1, c2 = points @ [np.cos(angle), np.sin(angle)], points @ [-np.sin(angle), np.cos(angle)]
    d1, d2 = nearer_side(c1), nearer_side(c2)
    e1, e2 = d1[d1 < d2], d2[d2 < d1]
    area = -np.ptp(c1) * np.ptp(c2)
    closeness = np.sum(1.0 / np.maximum(np.minimum(d1, d2), floor))
    return area, closeness, -sum(np.var(e) for e in (e1, e2) if len(e))


def side_distances(points, heading):
    """Distance of one line's points to the nearer direction of a rectangle, through their median."""
    along, across = points @ [np.cos(heading), np.sin(heading)], points @ [-np.sin(heading), np.cos(heading)]
    place = across if np.var(across) <= np.var(along) else along
    return np.abs(place - np.median(place))
