"""Reference implementations of the kernels of detection: exhaustive searches in plain numpy."""

import math

import numpy as np


def connected(points, radius):
    """Lowest index of each point's component, by flood fill over all pairs."""
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


def near_pairs(points, locality):
    """Pairs of points at different places, nearer than a fraction of the diagonal of the box around all."""
    reach = locality * np.linalg.norm(np.ptp(points, axis=0))
    pairs = [(i, j) for i in range(len(points)) for j in range(i)]
    return [(i, j) for i, j in pairs if 0.0 < math.dist(points[i], points[j]) < reach]


def preferences(points, lines, tau):
    """Equation (1), (M, N)."""
    distance = np.abs(lines[:, :2] @ points.T + lines[:, 2:])
    return np.where(distance < tau, np.exp(-distance / tau), 0.0)


def tanimoto(p, q):
    """Equation (2)."""
    product = np.dot(p, q)
    return 1.0 - product / (np.dot(p, p) + np.dot(q, q) - product) if product > 0 else 1.0


def agglomerate(table):
    """Algorithm 1 literally: search all pairs for the least distance, merge, repeat."""
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
    """Distances to the lower or upper edge, whichever has the smaller norm (Zhang 2017)."""
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
    """Distance of a line's points to the side of a rectangle along the line, through their median."""
    along, across = points @ [np.cos(heading), np.sin(heading)], points @ [-np.sin(heading), np.cos(heading)]
    place = across if np.var(across) <= np.var(along) else along
    return np.abs(place - np.median(place))


def kernel_sum(place, reach):
    """Every point's sum of (1 - (d / reach)^2)^2 over all others."""
    distance = np.abs(place[:, None] - place)
    return np.sum(np.maximum(0.0, 1.0 - (distance / reach) ** 2) ** 2, axis=1) - 1.0


def local_density(place, reach, bins):
    """The same sum, with each place interpolated between the two nodes around it."""
    at = (place - place.min()) * bins / reach
    node = np.arange(np.ceil(at.max()) + 2)
    share = np.maximum(0.0, 1.0 - np.abs(at[:, None] - node))
    kernel = (1.0 - (np.arange(-bins, bins + 1) / bins) ** 2) ** 2
    around = np.convolve(share.sum(axis=0), kernel)[bins : bins + len(node)]
    # A place has shares of two nodes beside each other; what it adds to itself does not count.
    own = np.sum(share**2, axis=1) + 2.0 * kernel[bins + 1] * np.sum(share[:, :-1] * share[:, 1:], axis=1)
    return share @ around - own


def misalignment(points, heading, ray, reach, flatness, bins):
    """Minus the mean log of one plus the higher of the densities along and across the heading."""
    density = []
    for normal in ([np.cos(heading), np.sin(heading)], [-np.sin(heading), np.cos(heading)]):
        sharpness = np.hypot(reach * np.dot(normal, ray), flatness)
        density.append(local_density(points @ normal, sharpness, bins) / sharpness)
    return -np.mean(np.log(1.0 + reach * np.maximum(*density)))


def chance(count, support, share):
    """Expected lines with `support` of `count` scattered points near them, for lines through every pair of points."""
    others, hits = count - 2, support - 2
    tail = [math.comb(others, j) * share**j * (1 - share) ** (others - j) for j in range(hits, others + 1)]
    return math.comb(count, 2) * math.fsum(tail)


def find_lines(points, clusters, tau, length_min, turn_min):
    """Lines of the clusters (index arrays into the sample's points) that are not outliers."""
    lines, free, share = [], np.ones(len(points), bool), 1.0
    for members in clusters:
        line = fit_line(members)
        member = free & (np.abs(points @ line[:2] + line[2]) < tau)
        if member.sum() > 2:
            line = fit_line(points[member])
        member = free & (np.abs(points @ line[:2] + line[2]) < tau)
        direction = np.array([line[1], -line[0]])
        if not lines:
            length, width = np.ptp(points @ direction), np.ptp(points @ line[:2])
            share = min(0.999, 2 * tau * np.hypot(length, width) / ((length + 2 * tau) * (width + 2 * tau)))
        else:
            turned = all(abs(other[:2] @ direction) >= turn_min for other in lines)
            if member.sum() <= 2 or len(members) <= 2 or not turned or np.ptp(points[member] @ direction) < length_min:
                continue
            if chance(free.sum(), member.sum(), share) > 1.0:
                continue
        lines.append(line)
        free &= ~member
    return np.array(lines)


def settle(points, lines, tau):
    """Assign, fit, assign again, then number by size."""
    label = assign(points, lines, tau)
    fits = [fit_line(points[label == k]) if np.sum(label == k) > 2 else lines[k] for k in range(len(lines))]
    label = assign(points, np.array(fits), tau)
    size = np.bincount(label[label >= 0], minlength=len(lines))
    ordered = sorted(range(len(lines)), key=lambda k: (-size[k], k))
    place = {k: rank if rank == 0 or size[k] > 2 else -1 for rank, k in enumerate(ordered)}
    return np.array([place.get(k, -1) for k in label])


def extents(points, heading, range_std, flatness, sigma):
    """Lowest and highest place (M, 2) of one segment's sides along and across headings (M,)."""
    low, high = np.empty((len(heading), 2)), np.empty((len(heading), 2))
    for m, angle in enumerate(heading):
        for axis in range(2):
            place = points @ [math.cos(angle + axis * math.pi / 2), math.sin(angle + axis * math.pi / 2)]
            cosine = np.abs(place) / np.maximum(np.linalg.norm(points, axis=1), flatness)
            reach = sigma * np.hypot(range_std * cosine, flatness)
            for sign, ends in ((-1.0, low), (1.0, high)):
                side = np.max(sign * place)
                for _ in range(2):
                    side = np.mean(sign * place[sign * place >= side - reach])
                ends[m, axis] = sign * side
    return low, high
