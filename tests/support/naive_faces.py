"""Reference implementations of the kernels of `luxloop.tracker.detection.faces` in plain numpy."""

import itertools

import numpy as np
from support import naive_fit


def inward(points, line, tau, ego_reach=2.5):
    """Line with its normal oriented into the body."""
    depth = points[:, :2] @ line[:2] + line[2]
    balance = np.sign(depth[np.abs(depth) > tau]).sum()
    side = balance if abs(line[2]) < ego_reach and balance != 0 else -line[2]
    return line if side > 0 else -line


def depths(points, face, noise):
    """Depth, place along the face, and standard deviation of the depth."""
    xy = points[:, :2]
    cosine = (xy @ face[:2]) / np.maximum(np.linalg.norm(xy, axis=1), 1e-9)
    return xy @ face[:2] + face[2], xy @ [face[1], -face[0]], np.hypot(noise[0] * cosine, noise[1])


def explained(first, aside, second, gates, depth_max):
    """Points on a face minus those outside or well inside."""
    outside = (first < -gates[0]) | (second < -gates[1])
    on = ~outside & ((first < gates[0]) | (second < gates[1]))
    curved = (aside & (first < depth_max)) | (second < depth_max)
    return on.sum() - outside.sum() - (~outside & ~on & ~curved).sum()


def across(points, chosen, face, noise, gate, depth_max, beyond_max, length_min):
    """Best score of a face with a perpendicular one through one of the points with indices `chosen`, and that face."""
    depth, place, std = depths(points, face, noise)
    turned = np.array([face[1], -face[0], 0.0])
    gates = gate * np.stack([std, depths(points, turned, noise)[2]])
    ends = place[np.abs(depth) < gates[0]]
    aside = (place > np.min(ends, initial=np.inf) - beyond_max) & (place < np.max(ends, initial=-np.inf) + beyond_max)
    best, other = explained(depth, aside, np.full(len(points), np.inf), gates, depth_max), np.zeros(3)
    for c, sign in itertools.product(chosen[depth[chosen] >= gates[0, chosen]], (1.0, -1.0)):
        on = (depth > gates[0]) & (np.abs(place - place[c]) < gates[1])
        if on.sum() < 2 or np.ptp(depth[on]) < length_min:
            continue
        score = explained(depth, aside, sign * (place - place[c]), gates, depth_max)
        if score > best:
            best, other = score, sign * np.array([face[1], -face[0], -place[on].mean()])
    return best, other


def best_corner(points, clusters, chosen, tau, noise, gate, depth_max, beyond_max, length_min):
    """Corner of the cluster (points, largest first) whose line explains most points."""
    best, corner = (-np.inf, 0.0), None
    for rank, members in enumerate(clusters):
        line = naive_fit.fit_line(members)
        on = np.abs(points @ line[:2] + line[2]) < tau
        if on.sum() > 2:
            line = naive_fit.fit_line(points[on])
            on = np.abs(points @ line[:2] + line[2]) < tau
        length = np.ptp(points[on] @ [line[1], -line[0]]) if on.any() else -np.inf
        if rank and (len(members) <= 2 or length < length_min):
            continue
        face = inward(points, line, tau)
        score, other = across(points, chosen, face, noise, gate, depth_max, beyond_max, 0.5 * length_min)
        if (score, length**2 * on.sum()) > best:
            best, corner = (score, length**2 * on.sum()), np.stack([face, other])
    return corner


def fit_corner(points, corner, noise, gate, rounds=2):
    """Heading by singular values of the weighted, centred points of one face and the rotated ones of the other."""
    corner = corner.copy()
    for _ in range(rounds):
        real = [k for k in range(2) if corner[k].any()]
        ratio = np.full((2, len(points)), np.inf)
        for k in real:
            depth, _, std = depths(points, corner[k], noise)
            ratio[k] = np.abs(depth) / std
        member = np.where(ratio.min(axis=0) < gate, ratio.argmin(axis=0), -1)
        rows, mean, uncertainty = [], {}, np.zeros((2, 3))
        for k in real:
            on, weight = member == k, 1.0 / depths(points, corner[k], noise)[2] ** 2
            if not on.any():
                corner[k] = 0.0
                continue
            mean[k] = np.average(points[on], axis=0, weights=weight[on])
            row = (points[on] - mean[k]) * np.sqrt(weight[on, None])
            rows.append(row if k == 0 else row[:, ::-1] * [1.0, -1.0])
            uncertainty[k, 1:] = 1.0 / weight[on].sum(), np.sum(row**2)
        x, y = np.linalg.svd(np.concatenate(rows))[2][0]
        for k in mean:
            normal = np.array([-y, x]) if k == 0 else np.array([x, y])
            normal *= np.sign(normal @ corner[k, :2])
            corner[k] = [*normal, -normal @ mean[k]]
            uncertainty[k, 0] = mean[k] @ [normal[1], -normal[0]]
    order = [1, 0] if uncertainty[1, 2] > uncertainty[0, 2] else [0, 1]
    uncertainty[:, 2] = 1.0 / uncertainty[:, 2].sum()
    return corner[order], uncertainty[order]


def label_body(points, corner, uncertainty, noise, gate, depth_max, beyond_max, pitch):
    """Face of each body point."""
    n, real = len(points), [k for k in range(2) if corner[k].any()]
    depth, place, std = np.full((2, n), np.inf), np.zeros((2, n)), np.ones((2, n))
    for k in real:
        depth[k], place[k], std[k] = depths(points, corner[k], noise)
        std[k] = np.sqrt(std[k] ** 2 + uncertainty[k, 1] + (place[k] - uncertainty[k, 0]) ** 2 * uncertainty[k, 2])
    ratio = np.abs(depth) / std
    member = np.where(ratio.min(axis=0) < gate, ratio.argmin(axis=0), -1)
    ends = [
        (np.min(place[k, member == k], initial=np.inf), np.max(place[k, member == k], initial=-np.inf))
        for k in range(2)
    ]
    label, outside = np.full(n, -1), np.zeros(n, bool)
    behind = np.full((2, n), np.inf)
    for k in real:
        low, high = ends[k]
        is_end = high - low <= 2.8 < ends[1 - k][1] - ends[1 - k][0]
        out = depth[k] < -gate * std[k] * (2 if is_end else 1)
        right = ~out & (depth[k] < depth_max) & (place[k] > low - beyond_max) & (place[k] < high + beyond_max)
        behind[k, right] = np.abs(depth[k, right])
        outside |= out
    label = np.where(np.isfinite(behind.min(axis=0)), behind.argmin(axis=0), -1)
    for k, sign in itertools.product(real, (1.0, -1.0)):
        along = sign * np.array([corner[k, 1], -corner[k, 0]])
        if len(real) == 2 and along @ corner[1 - k, :2] < 0:
            continue  # the other face is at this end
        seen = sign * place[k, (label == k) & ~outside]
        if len(seen) == 0 or np.ptp(seen) < 1.0:
            continue
        edge = seen.max()
        beyond = sign * place[k] - edge
        open_ = (depth[k] >= depth_max) & ~outside & ((label < 0) | (label == k))
        far = open_ & (beyond > gate * noise[1] + pitch * np.linalg.norm(points[:, :2], axis=1))
        label[open_ & ~far & (beyond > -depth_max)] = 2 * k + (2 if sign > 0 else 3)
        outside |= far
    label[outside] = -1
    if points.shape[1] > 2:
        for k in real:
            drop_mirrors(points[:, 2], label, depth[k], place[k], std[k])
    if not np.any(label == 0):
        label[np.argmin(np.abs(depth[0]))] = 0
    return label


def drop_mirrors(height, label, depth, place, std):
    """Remove the bases of mirrors."""
    sure = (label < 0) & (depth > -0.35) & (depth < -4.0 * std) & (height > 0.75)
    done = np.zeros(len(label), bool)
    for i in np.flatnonzero(sure):
        if not done[i]:
            middle = place[sure & (np.abs(place - place[i]) < 0.2)].mean()
            here = (np.abs(place - middle) < 0.08) & (np.abs(height - height[i]) < 0.12)
            done |= here
            label[here & (depth < 0.06)] = -1


def excess(points, corner, noise, tau):
    """Median distance from the nearer face, relative to that of normal noise, at least 1."""
    real = [depths(points, face, noise) for face in corner if face.any()]
    ratios = [np.where(np.abs(depth) < tau, np.abs(depth) / std, np.inf) for depth, _, std in real]
    on = np.min(ratios, axis=0)
    return max(1.0, np.median(on[np.isfinite(on)]) / 0.6745) if np.isfinite(on).any() else 1.0
