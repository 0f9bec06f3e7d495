"""All beams of a rig against the world: the sweep, fan by fan.

A fan fires one beam a layer at each of its azimuths. A beam is I rays, one above the other, times J, side by side. So a
fan has J columns an azimuth, and the rays of a column are those of all its layers: ray i belongs to layer i // I, column
m to azimuth m // J.
"""

import math

import numpy as np
from numba import njit

from sensor_model.kernels import echoes, rays
from sensor_model.kernels.records import Beams, Drive, Fans, Floats, Ints, Solids, Surroundings, Units
from sensor_model.kernels.sight import in_sight
from sensor_model.returns import GROUND, NOTHING, WALL


@njit(cache=True)
def cast_rig(
    fans: Fans, beams: Beams, units: Units, bodies: Solids, around: Surroundings, drive: Drive, frame: int,
    echo: Floats, echo_id: Ints, lost_beam: Ints, lost_echo: Floats, free_range: Floats,
    unit_hits: Ints, unit_hits_alone: Ints,
) -> tuple[int, int]:  # fmt: skip
    """Sweep the rig once.

    Parameters
    ----------
    frame
        Number of the frame, which decides which fans fire.
    echo, echo_id
        Out: echoes in the order of fan, azimuth and layer; columns as in `kernels.echoes`.
    lost_beam, lost_echo
        Out: beams that met something and have no echo; the most that came back at once, and from where (range, power).
    free_range
        (B,) in and out: how far each beam's rays get, or (0,) if nobody asks.
    unit_hits, unit_hits_alone
        (U, A) in and out: rays that end on each body, and that would if it were alone on the ground.

    Returns
    -------
    How many echoes there are, and how many lost beams.
    """
    found, lost = 0, 0
    for f in range(len(fans.fan_unit)):
        if frame % fans.fan_turn[f, 1] == fans.fan_turn[f, 0]:
            u = fans.fan_unit[f]
            found, lost = _cast_fan(
                f, fans, beams, units, bodies, around, drive, echo, echo_id, found, lost_beam, lost_echo, lost,
                free_range, unit_hits[u], unit_hits_alone[u],
            )  # fmt: skip
    return found, lost


@njit(cache=True)
def cast_rays(
    origin: Floats, direction: Floats, time: Floats, range_max: float, bodies: Solids, around: Surroundings
) -> tuple[Floats, Floats, Floats]:
    """Cast single rays from origins (G, 3) along directions (G, 3), each at its time (G,).

    Returns
    -------
    (G,) range, infinite where a ray meets nothing; reflectivity of what it meets, and cosine of the angle of incidence.
    """
    count = len(time)
    column, seen = np.zeros((9, count)), np.empty((9, count))
    column[:3], column[3:6] = origin.T, direction.T
    cos, sin = np.ones((1, count)), np.zeros((1, count))
    open_range, nearest, cosine, inner_range, own_range = np.empty((5, 1, count))
    target, surface, own_surface = np.empty((3, 1, count), np.int64)
    rays.meet_ground(
        column, cos, sin, range_max, GROUND, NOTHING, open_range, nearest, target, surface, cosine, inner_range
    )
    for w in range(len(around.ends)):
        rays.meet_wall(column, cos, sin, 0, count, around.ends, around.z, w, WALL, nearest, target, surface, cosine)
    for a in range(len(bodies.motion)):
        rays.into_body(column, 0, count, 1, time, bodies.motion, a, seen)
        rays.enter_body(
            False, a, bodies.body_solid, bodies.solid_plane, bodies.solid_bounds, bodies.solid_inner, bodies.planes,
            seen, 0, count, cos, sin, open_range, own_range, own_surface,
        )  # fmt: skip
        _keep_nearer(
            a, bodies.planes, bodies.transmission, seen, 0, count, cos, sin, own_range, own_surface,
            nearest, target, surface, cosine, inner_range,
        )  # fmt: skip
    reflectivity = np.zeros(count)
    for g in range(count):
        met, q = target[0, g], surface[0, g]
        if met == NOTHING:
            nearest[0, g] = math.inf
        else:
            reflectivity[g] = _reflectivity(met, q, around.ground_reflectivity, around.reflectivity, bodies.reflectivity)
    return nearest[0], reflectivity, cosine[0]


@njit(cache=True)
def _reflectivity(met: int, q: int, ground: float, walls: Floats, planes: Floats) -> float:
    """Of surface q of a target."""
    return ground if met == GROUND else walls[q] if met == WALL else planes[q]


@njit(cache=True)
def _cast_fan(
    f: int, fans: Fans, beams: Beams, units: Units, bodies: Solids, around: Surroundings, drive: Drive,
    echo: Floats, echo_id: Ints, found: int, lost_beam: Ints, lost_echo: Floats, lost: int, free_range: Floats,
    hits: Ints, hits_alone: Ints,
) -> tuple[int, int]:  # fmt: skip
    """Cast fan f: start its rays, shorten them thing by thing, and listen to what comes back."""
    u = fans.fan_unit[f]
    beam = fans.row_beam[fans.fan_row[f] : fans.fan_row[f + 1]]  # the first of each layer
    azimuths = fans.row_beam[fans.fan_row[f] + 1] - beam[0]
    time = beams.time[beam[0] : beam[0] + azimuths]
    per = units.turn.shape[1]
    shape = (len(beam) * units.rise.shape[1], azimuths * per)

    column, seen = np.empty((9, shape[1])), np.empty((9, shape[1]))
    cos, sin, open_range, nearest, cosine = np.empty((5, *shape))
    inner_range, inner_cosine, own_range = np.empty((3, *shape))
    target, surface, inner_surface, own_surface = np.empty((4, *shape), np.int64)
    _aim(beams.direction, beam, time, units.origin[u], units.rotation[u], units.turn[u], drive, column)
    _raise(beams.direction, beam, units.rise[u], per, cos, sin)
    rays.meet_ground(
        column, cos, sin, units.range_max[u], GROUND, NOTHING, open_range, nearest, target, surface, cosine, inner_range
    )
    body_rows, wall_rows = in_sight(fans, f, beams, units, bodies, around, drive)
    for w, first, end in wall_rows:
        rays.meet_wall(
            column, cos, sin, first * per, end * per, around.ends, around.z, w, WALL, nearest, target, surface, cosine
        )
    for a, begin, stop in body_rows:
        first, end = begin * per, stop * per
        rays.into_body(column, first, end, per, time, bodies.motion, a, seen)
        rays.enter_body(
            False, a, bodies.body_solid, bodies.solid_plane, bodies.solid_bounds, bodies.solid_inner, bodies.planes,
            seen, first, end, cos, sin, open_range, own_range, own_surface,
        )  # fmt: skip
        alone, panes = _keep_nearer(
            a, bodies.planes, bodies.transmission, seen, first, end, cos, sin, own_range, own_surface,
            nearest, target, surface, cosine, inner_range,
        )  # fmt: skip
        hits_alone[a] += alone
        if panes:
            rays.enter_body(
                True, a, bodies.body_solid, bodies.solid_plane, bodies.solid_bounds, bodies.solid_inner, bodies.planes,
                seen, first, end, cos, sin, open_range, own_range, own_surface,
            )  # fmt: skip
            _look_inside(
                a, bodies.planes, bodies.transmission, seen, first, end, cos, sin, own_range, own_surface,
                target, surface, inner_range, inner_surface, inner_cosine,
            )  # fmt: skip
    _count(target, hits)
    if len(free_range) > 0:
        _free(beam, per, units.range_max[u], nearest, free_range)
    return _listen(
        u, beam, beams, units, bodies, around, per, nearest, target, surface, cosine,
        inner_range, inner_surface, inner_cosine, echo, echo_id, found, lost_beam, lost_echo, lost,
    )  # fmt: skip


@njit(cache=True)
def _aim(
    direction: Floats, beam: Ints, time: Floats, origin: Floats, rotation: Floats, turn: Floats, drive: Drive,
    column: Floats,
) -> None:  # fmt: skip
    """Fill the columns (9, M) of a fan: origin, forward and up where its unit is when they fire."""
    per = len(turn)
    for k in range(len(time)):
        t, half = time[k], 0.5 * time[k] * time[k]
        ego_cos, ego_sin = math.cos(drive.yaw_rate * t), math.sin(drive.yaw_rate * t)
        x = ego_cos * origin[0] - ego_sin * origin[1] + drive.vx * t + drive.ax * half
        y = ego_sin * origin[0] + ego_cos * origin[1] + drive.vy * t + drive.ay * half
        up_x = ego_cos * rotation[0, 2] - ego_sin * rotation[1, 2]
        up_y = ego_sin * rotation[0, 2] + ego_cos * rotation[1, 2]
        cos, sin = direction[beam[0] + k, 0], direction[beam[0] + k, 1]
        for j in range(per):
            m = k * per + j
            ca, sa = cos * turn[j, 0] - sin * turn[j, 1], sin * turn[j, 0] + cos * turn[j, 1]
            fx, fy = rotation[0, 0] * ca + rotation[0, 1] * sa, rotation[1, 0] * ca + rotation[1, 1] * sa
            column[0, m], column[1, m], column[2, m] = x, y, origin[2]
            column[3, m], column[4, m] = ego_cos * fx - ego_sin * fy, ego_sin * fx + ego_cos * fy
            column[5, m] = rotation[2, 0] * ca + rotation[2, 1] * sa
            column[6, m], column[7, m], column[8, m] = up_x, up_y, rotation[2, 2]


@njit(cache=True)
def _raise(direction: Floats, beam: Ints, rise: Floats, per: int, cos: Floats, sin: Floats) -> None:
    """Fill (n, M) cosine and sine of the elevations of a fan's rays."""
    rises = len(rise)
    for i in range(len(cos)):
        first, c, s = beam[i // rises], rise[i % rises, 0], rise[i % rises, 1]
        for k in range(cos.shape[1] // per):
            ce, se = direction[first + k, 2], direction[first + k, 3]
            for j in range(per):
                cos[i, k * per + j], sin[i, k * per + j] = ce * c - se * s, se * c + ce * s


@njit(cache=True)
def _keep_nearer(
    a: int, planes: Floats, transmission: Floats, seen: Floats, first: int, end: int, cos: Floats, sin: Floats,
    own_range: Floats, own_surface: Ints, nearest: Floats, target: Ints, surface: Ints, cosine: Floats,
    inner_range: Floats,
) -> tuple[int, bool]:  # fmt: skip
    """End the rays on body a that meet it first; return how many would alone, and whether any ends on a pane."""
    alone, panes = 0, False
    for i in range(len(cos)):
        for m in range(np.uint64(first), np.uint64(end)):
            q = own_surface[i, m]
            if q != rays.NONE:
                alone += 1
                if own_range[i, m] < nearest[i, m]:
                    nearest[i, m], target[i, m], surface[i, m] = own_range[i, m], a, q
                    cosine[i, m] = rays.incidence(planes, q, seen, m, cos[i, m], sin[i, m])
                    inner_range[i, m] = math.inf
                    panes = panes or transmission[q] > 0.0
    return alone, panes


@njit(cache=True)
def _look_inside(
    a: int, planes: Floats, transmission: Floats, seen: Floats, first: int, end: int, cos: Floats, sin: Floats,
    own_range: Floats, own_surface: Ints, target: Ints, surface: Ints,
    inner_range: Floats, inner_surface: Ints, inner_cosine: Floats,
) -> None:  # fmt: skip
    """Let the rays that end on a pane of body a go on to what is behind it."""
    for i in range(len(cos)):
        for m in range(np.uint64(first), np.uint64(end)):
            q = own_surface[i, m]
            if q != rays.NONE and target[i, m] == a and transmission[surface[i, m]] > 0.0:
                inner_range[i, m], inner_surface[i, m] = own_range[i, m], q
                inner_cosine[i, m] = rays.incidence(planes, q, seen, m, cos[i, m], sin[i, m])


@njit(cache=True)
def _count(target: Ints, hits: Ints) -> None:
    """Count the rays that end on each body."""
    for i in range(len(target)):
        for m in range(target.shape[1]):
            if target[i, m] >= 0:
                hits[target[i, m]] += 1


@njit(cache=True)
def _free(beam: Ints, per: int, range_max: float, nearest: Floats, free_range: Floats) -> None:
    """Set how far the beams of a fan get: as far as the farthest of their rays, infinitely if one meets nothing."""
    rises = len(nearest) // len(beam)
    for layer in range(len(beam)):
        for k in range(nearest.shape[1] // per):
            farthest = 0.0
            for i in range(layer * rises, (layer + 1) * rises):
                for m in range(k * per, (k + 1) * per):
                    farthest = max(farthest, nearest[i, m])
            free_range[beam[layer] + k] = farthest if farthest < range_max else math.inf


@njit(cache=True)
def _listen(
    u: int, beam: Ints, beams: Beams, units: Units, bodies: Solids, around: Surroundings, per: int,
    nearest: Floats, target: Ints, surface: Ints, cosine: Floats,
    inner_range: Floats, inner_surface: Ints, inner_cosine: Floats,
    echo: Floats, echo_id: Ints, found: int, lost_beam: Ints, lost_echo: Floats, lost: int,
) -> tuple[int, int]:  # fmt: skip
    """Turn what comes back to each beam of a fan into echoes, or count the beam as lost."""
    rises = len(nearest) // len(beam)
    gain, threshold = beams.gain, beams.threshold
    reflectivity, transmission, wall_reflectivity = bodies.reflectivity, bodies.transmission, around.reflectivity
    ground_reflectivity, extinction = around.ground_reflectivity, around.extinction
    range_min, range_max = units.range_min[u], units.range_max[u]
    pulse_length, pulse_growth = units.pulse_length[u], units.pulse_growth[u]
    separation, most = units.echo_separation[u], units.echoes_max[u]
    sample, sample_id = np.empty((2 * rises * per, 2)), np.empty((2 * rises * per, 2), np.int64)
    for k in range(nearest.shape[1] // per):
        for layer in range(len(beam)):
            b = beam[layer] + k
            n = _gather(
                layer * rises, (layer + 1) * rises, k * per, (k + 1) * per, gain[b], range_min, range_max, extinction,
                ground_reflectivity, wall_reflectivity, reflectivity, transmission, nearest, target, surface, cosine,
                inner_range, inner_surface, inner_cosine, sample, sample_id,
            )  # fmt: skip
            if n == 0:
                continue
            echoes.sort_by_range(sample, sample_id, n)
            before = found
            found, highest, where = echoes.find_echoes(
                sample, sample_id, n, threshold[b], pulse_length, pulse_growth, separation, most, echo, echo_id, found
            )
            for e in range(before, found):
                echo_id[e, echoes.BEAM] = b
                echoes.name_echo(sample, sample_id, n, pulse_length, echo, echo_id, e)
            if found == before:
                lost_beam[lost], lost_echo[lost, echoes.RANGE], lost_echo[lost, echoes.POWER] = b, where, highest
                lost += 1
    return found, lost


@njit(cache=True, error_model="numpy")
def _gather(
    low: int, high: int, first: int, end: int, gain: float, range_min: float, range_max: float, extinction: float,
    ground_reflectivity: float, wall_reflectivity: Floats, reflectivity: Floats, transmission: Floats,
    nearest: Floats, target: Ints, surface: Ints, cosine: Floats,
    inner_range: Floats, inner_surface: Ints, inner_cosine: Floats, sample: Floats, sample_id: Ints,
) -> int:  # fmt: skip
    """Fill the samples of a beam, rays [low, high) of columns [first, end); return how many.

    Power is reflectivity x cos(incidence) x gain / range^2 (Lambert), weakened by the air, in equal parts for the rays.
    """
    share = gain / ((high - low) * (end - first))
    n = 0
    for i in range(low, high):
        for m in range(first, end):
            met, q, r = target[i, m], surface[i, m], nearest[i, m]
            if met == NOTHING or r < range_min:
                continue
            rho = _reflectivity(met, q, ground_reflectivity, wall_reflectivity, reflectivity)
            sample[n, echoes.RANGE], sample[n, echoes.POWER] = r, _power(rho * cosine[i, m] * share, r, extinction)
            sample_id[n, echoes.TARGET], sample_id[n, echoes.SURFACE] = met, q
            n += 1
            if inner_range[i, m] < range_max:
                q, behind, r = inner_surface[i, m], surface[i, m], inner_range[i, m]
                sent = transmission[behind] * reflectivity[q] * inner_cosine[i, m] * share
                sample[n, echoes.RANGE], sample[n, echoes.POWER] = r, _power(sent, r, extinction)
                sample_id[n, echoes.TARGET], sample_id[n, echoes.SURFACE] = met, q
                n += 1
    return n


@njit(cache=True, error_model="numpy")
def _power(sent: float, r: float, extinction: float) -> float:
    """What comes back from a range."""
    air = math.exp(-2.0 * extinction * r) if extinction > 0.0 else 1.0
    return sent / (r * r) * air
