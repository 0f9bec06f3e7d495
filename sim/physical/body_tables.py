"""Tables and ring buffers with one row per nearby road user, and their growth."""

from typing import Any

import numpy as np
import numpy.typing as npt

from luxloop.arrays import Ints
from luxloop.sim.articulation import hitch, is_articulated
from luxloop.sim.physical.kernels.records import NO_FRAME, BodyDimensions, BodyStates, RawHistory
from luxloop.sim.physical.limits import YAW_RATE_ON_FOOT, YAW_RATE_ON_WHEELS
from luxloop.sim.roster import EGO_ID, Member
from luxloop.sim.sections import is_on_rails, section_count
from luxloop.sim.world import Kind

REAR_AXLE = 0.8
"""Rear axle behind the front bumper, as a share of the length: of cars and, roughly, of all other kinds."""
SHORTEST_LEAD = 0.3
"""[m] Minimum distance from rear axle to front; it applies to pedestrians."""


class BodyTables:
    """State of the truth layer. Rows of departed road users are reused, so that memory stays bounded in long runs.

    Parameters
    ----------
    window, trail
        Frames to keep of the raw history, and of the smoothed paths.
    """

    def __init__(self, window: int, trail: int):
        empty = (np.zeros(0) for _ in BodyDimensions._fields)
        self.dimensions = BodyDimensions(*empty)
        self.history = RawHistory(
            frame=np.zeros((0, window), np.int64),
            changes_lane=np.zeros((0, window), np.bool_),
            raw=np.zeros((0, window, 3)),
            path=np.zeros((0, window, 3)),
            speed=np.zeros((0, window)),
        )
        self.states = BodyStates(
            state=np.zeros((0, 10)),
            last_frame=np.zeros(0, np.int64),
            first_frame=np.zeros(0, np.int64),
            trail=np.zeros((0, trail, 6)),
        )
        self._row: dict[tuple[int, int], int] = {}
        """Row by id and stretch: a body that the simulator moved elsewhere starts there in steady motion."""
        self._free: list[int] = []
        self._last = np.zeros(0, np.int64)

    def rows(self, members: list[Member], frame: int) -> Ints:
        """Return the rows (N,) of the members of a pushed frame; allocate rows for new members."""
        for member in members:
            if (member.id, member.stretch) not in self._row:
                self._row[member.id, member.stretch] = self._allocate(member)
        rows = np.array([self._row[member.id, member.stretch] for member in members])
        self._last[rows] = frame
        return rows

    def release(self, frame: int) -> None:
        """Free the rows of members that were last pushed before a frame."""
        for key in [key for key, row in self._row.items() if self._last[row] < frame]:
            self._free.append(self._row.pop(key))

    def _allocate(self, member: Member) -> int:
        """Return a free row, filled with the member's dimensions."""
        if not self._free:
            capacity = 2 * len(self._last) + 64
            self._free = list(range(capacity - 1, len(self._last) - 1, -1))
            self._resize(capacity)
        row = self._free.pop()
        for column, value in zip(self.dimensions, _dimensions_of(member), strict=True):
            column[row] = value
        self.history.frame[row] = NO_FRAME
        self.states.last_frame[row] = NO_FRAME
        return row

    def _resize(self, capacity: int) -> None:
        self.dimensions = BodyDimensions(*(_resized(column, capacity) for column in self.dimensions))
        self.history = RawHistory(*(_resized(ring, capacity) for ring in self.history))
        self.states = BodyStates(*(_resized(column, capacity) for column in self.states))
        self._last = _resized(self._last, capacity)


def _dimensions_of(member: Member) -> BodyDimensions:
    """Return the dimensions of one body."""
    length = member.size[0]
    on_foot = member.kind is Kind.PEDESTRIAN
    front_offset = max(REAR_AXLE * length, SHORTEST_LEAD)
    yaw_rate_max = YAW_RATE_ON_FOOT if on_foot else YAW_RATE_ON_WHEELS
    kind, lengths = np.array([member.kind], np.uint8), np.array([length])
    if has_sections(member):
        section = length / float(section_count(kind, lengths)[0])
        lead = REAR_AXLE * section
        return BodyDimensions(length, lead, lead - 0.5 * section, yaw_rate_max, lead, 0.0, 0.0, 0.0)  # type: ignore[arg-type]  # scalars of one body
    if not is_articulated(kind, lengths)[0] or member.id == EGO_ID:  # the ego record has no articulation angle
        centre = front_offset - 0.5 * length
        return BodyDimensions(length, front_offset, centre, yaw_rate_max, centre, 0.0, 0.0, 0.0)  # type: ignore[arg-type]
    coupling = hitch(lengths, kind)
    drive, pin, axles = (float(at[0]) for at in (coupling.drive_axle, coupling.kingpin, coupling.trailer_axles))
    ahead = drive - pin
    return BodyDimensions(length, drive, 0.0, yaw_rate_max, ahead, ahead, axles - pin, pin - 0.5 * length)  # type: ignore[arg-type]


def has_sections(member: Member) -> bool:
    """Return True if sections of the body follow along the driven path: for trams and trains except the ego."""
    if member.kind is not Kind.BUS or member.id == EGO_ID:
        return False
    return bool(is_on_rails(np.array([member.kind], np.uint8), np.array([member.size[0]]))[0])


def _resized(array: npt.NDArray[Any], capacity: int) -> npt.NDArray[Any]:
    """Return the array with `capacity` rows; new rows are zero."""
    return np.concatenate([array, np.zeros((capacity - len(array), *array.shape[1:]), array.dtype)])
