"""Clutter echoes, and their merging with the echoes of surfaces."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from luxloop import elementwise
from luxloop.arrays import Bools, Bytes, Floats, Ints
from luxloop.sensor_model.kernels.noise import separate_echoes
from luxloop.sensor_model.noise.thresholds import Thresholds
from luxloop.sensor_model.returns import NOTHING, Returns
from luxloop.sensor_model.rig.beams import BeamTable
from luxloop.sensor_model.truth import Cause, Part
from luxloop.tracker.scan import PointFlag


@dataclass(frozen=True, slots=True, eq=False)
class Clutter:
    """C unordered echoes."""

    beam: Ints
    """(C,) row of the beam table."""
    range: Floats
    """(C,) [m]."""
    width: Floats
    """(C,) width of the pulse above the threshold [m]."""
    power: Floats
    """(C,) as in `Returns` [1/m^2]."""
    part: Bytes
    """(C,) `Part`: DROPLET, which nearer surfaces occlude, or NONE."""
    cause: Bytes
    """(C,) `Cause`."""
    flags: npt.NDArray[np.uint16]
    """(C,) `PointFlag`."""

    def __len__(self) -> int:
        return len(self.beam)


def weak_clutter(
    beam: Ints, range_: Floats, chance: Floats, part: Part, cause: Cause, labelled: Bools, beams: BeamTable,
    thresholds: Thresholds,
) -> Clutter:  # fmt: skip
    """Return clutter with powers above the unit's nominal threshold; beams that do not fire are dropped.

    The power is nominal / chance, so that a share of 1 / x of the echoes exceeds x times the threshold. In decibels
    that is an exponential distribution of mean 4.3 dB: weak echoes are frequent, strong ones are rare.

    Parameters
    ----------
    beam, range_, labelled
        (C,) rows of the beam table, ranges [m], and mask of the echoes that the unit flags as clutter.
    chance
        (C,) uniform draws in (0, 1).
    """
    firing = thresholds.firing[beam]
    beam, range_, labelled = beam[firing], range_[firing], labelled[firing]
    power = thresholds.nominal[beam] / chance[firing]
    return Clutter(
        beam=beam,
        range=range_,
        width=point_width(beam, power, thresholds.threshold, beams),
        power=power,
        part=np.full(len(beam), part, dtype=np.uint8),
        cause=np.full(len(beam), cause, dtype=np.uint8),
        flags=np.where(labelled, PointFlag.CLUTTER, PointFlag(0)).astype(np.uint16),
    )


def droplets(
    beam: Ints, range_: Floats, cause: Cause, labelled: float, chance: Floats, beams: BeamTable, thresholds: Thresholds
) -> Clutter:
    """Return echoes of drops; a raised threshold detects nominal / threshold of them.

    Parameters
    ----------
    beam, range_
        (C,) rows of the beam table, and ranges [m].
    labelled
        Share of them that the unit flags as clutter.
    chance
        (2, C) independent draws in (0, 1): for the flag, and for the power, see `weak_clutter`.
    """
    seen = chance[1] * thresholds.threshold[beam] < thresholds.nominal[beam]
    beam, range_, (flag, power) = beam[seen], range_[seen], chance[:, seen]
    return weak_clutter(beam, range_, power, Part.DROPLET, cause, flag < labelled, beams, thresholds)


def point_width(beam: Ints, power: Floats, threshold: Floats, beams: BeamTable) -> Floats:
    """Return the (C,) widths of echoes of single points [m]: the receiver's model, as for surfaces.

    Parameters
    ----------
    beam, power
        (C,) rows of the beam table, and highest powers [1/m^2].
    threshold
        (B,) minimum power of an echo in each beam; above the power in a beam that is blind to surfaces.
    """
    over_db = 10.0 * elementwise.log10(np.maximum(power / threshold[beam], 1.0))
    unit = beams.unit[beam]
    width: Floats = beams.units.pulse_length[unit] + beams.units.pulse_growth[unit] * over_db
    return width


def unit_beams(beams: BeamTable) -> Ints:
    """Return (U + 1,) offsets: unit u has beams unit_beams[u] to unit_beams[u + 1] of the table."""
    return np.searchsorted(beams.unit, np.arange(len(beams.units) + 1)).astype(np.int64)


def unit_directions(beams: BeamTable) -> Floats:
    """Return (B, 3) unit vectors along the beams in the frames of their units."""
    directions: Floats = elementwise.product(beams.direction_ego[:, None], beams.units.R_ego_unit[beams.unit])[:, 0]
    return directions


def merge(returns: Returns, clutter: Sequence[Clutter], free_range: Floats, beams: BeamTable) -> Returns:
    """Merge clutter into the returns, with the echo separation of the units.

    Droplets behind a surface are occluded. Echoes that start closer to each other than the unit's echo separation
    become one, at the nearest range and widened to their common end. The nearest `echoes_max` remain.

    Parameters
    ----------
    returns
        Returns from surfaces.
    free_range
        (B,) unobstructed range of each beam, infinite without a surface [m].
    """
    visible = [_visible(some, free_range, beams) for some in clutter if len(some)]
    if not any(len(some) for some in visible):
        return returns
    both = _concatenated(returns, visible)
    # A single sort key: the returns are already sorted, so that a stable sort is fast.
    order = np.argsort(both.beam * (both.range.max() + 1.0) + both.range, kind="stable")
    beam = both.beam[order]
    unit = beams.unit[beam]
    kept, width = separate_echoes(
        beam, both.range[order], both.width[order], beams.units.echo_separation[unit], beams.units.echoes_max[unit]
    )
    rows = np.flatnonzero(kept)
    return _selected(both, order[rows], width[rows])


def _visible(clutter: Clutter, free_range: Floats, beams: BeamTable) -> Clutter:
    unit = beams.unit[clutter.beam]
    seen = (clutter.range >= beams.units.range_min[unit]) & (clutter.range <= beams.units.range_max[unit])
    seen &= (clutter.part != Part.DROPLET) | (clutter.range < free_range[clutter.beam])
    return Clutter(
        beam=clutter.beam[seen],
        range=clutter.range[seen],
        width=clutter.width[seen],
        power=clutter.power[seen],
        part=clutter.part[seen],
        cause=clutter.cause[seen],
        flags=clutter.flags[seen],
    )


def _concatenated(returns: Returns, clutter: list[Clutter]) -> Returns:
    count = sum(map(len, clutter))
    return Returns(
        beam=np.concatenate([returns.beam, *(some.beam for some in clutter)]),
        range=np.concatenate([returns.range, *(some.range for some in clutter)]),
        width=np.concatenate([returns.width, *(some.width for some in clutter)]),
        power=np.concatenate([returns.power, *(some.power for some in clutter)]),
        target=np.concatenate([returns.target, np.full(count, NOTHING, dtype=np.int64)]),
        surface=np.concatenate([returns.surface, np.zeros(count, dtype=np.int64)]),
        part=np.concatenate([returns.part, *(some.part for some in clutter)]),
        cause=np.concatenate([returns.cause, *(some.cause for some in clutter)]),
        point_body=np.concatenate([returns.point_body, np.zeros((count, 2))]),
        flags=np.concatenate([returns.flags, *(some.flags for some in clutter)]),
    )


def _selected(returns: Returns, rows: Ints, width: Floats) -> Returns:
    return Returns(
        beam=returns.beam[rows],
        range=returns.range[rows],
        width=width,
        power=returns.power[rows],
        target=returns.target[rows],
        surface=returns.surface[rows],
        part=returns.part[rows],
        cause=returns.cause[rows],
        point_body=returns.point_body.take(rows, axis=0),
        flags=returns.flags[rows],
    )
