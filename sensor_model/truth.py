"""What the caster knows and the tracker may not: where each point comes from, and what each actor shows."""

from dataclasses import dataclass
from enum import IntEnum, IntFlag

import numpy as np
import numpy.typing as npt

from sensor_model.arrays import Bytes, Floats, Ints

NO_ACTOR = -1
"""`ScanTruth.actor_id` of points on the ground, on obstacles and on nothing."""


class Part(IntEnum):
    """What a beam met."""

    NONE = 0
    GROUND = 1
    OBSTACLE = 2
    BODY = 3
    GREENHOUSE = 4
    """A pane of glass."""
    MIRROR = 5
    WHEEL = 6
    INTERIOR = 7
    """What is behind a pane."""
    DROPLET = 8
    """Rain or spray."""


class Cause(IntEnum):
    """Why a point is where it is. All but CLEAN are what outlier removal should find."""

    CLEAN = 0
    MIRROR = 1
    """On a side mirror of the vehicle."""
    LAYER_OVERLAP = 2
    """On a part of the vehicle well inside its outline: window behind the deck, wheel under the bumper."""
    RANGE_OUTLIER = 3
    """The unit measured a wrong range."""
    GHOST = 4
    """On nothing: the beam was reflected, and what it met is seen behind the mirror."""
    DOUBLED = 5
    """On an actor that several units see, out of place by their calibration or timing."""
    FALSE_ALARM = 6
    """On nothing: the detector fired by itself."""
    RAIN = 7
    """On a raindrop."""
    SPRAY = 8
    """On water thrown up by a vehicle."""


ON_NOTHING = (Cause.GHOST, Cause.FALSE_ALARM, Cause.RAIN, Cause.SPRAY)
"""Causes of points that lie on no actor and no obstacle."""


class Loss(IntEnum):
    """Why a beam has no echo of what it met."""

    THRESHOLD = 0
    """The echo was too weak."""
    RANDOM = 1
    """The detector's random floor."""
    OUTAGE = 2
    """The unit was silent."""
    DIRT = 3
    """Dirt on the unit's window took too much of it."""
    SUN = 4
    """The unit was too much dazzled for it."""
    RAIN = 5
    """Rain on the way took too much of it."""
    TOO_NEAR = 6
    """All that it met is nearer than the unit can measure."""


class Face(IntFlag):
    """Faces of a vehicle's outline."""

    FRONT = 1
    LEFT = 2
    REAR = 4
    RIGHT = 8


class View(IntEnum):
    """How much of a vehicle's outline returned points (table 1 of the paper)."""

    NONE = 0
    L_SHAPE = 1
    SIDE = 2
    REAR = 3
    FRONT = 4


@dataclass(frozen=True, slots=True, eq=False)
class ScanTruth:
    """Truth beside a `Scan` of N points, for the frame's A actors in the order of `WorldFrame.actors`."""

    actor_id: Ints
    """(N,) the actor the point lies on, `NO_ACTOR` where none."""
    part: Bytes
    """(N,) `Part`."""
    cause: Bytes
    """(N,) `Cause`."""
    true_range: npt.NDArray[np.float32]
    """(N,) range without noise [m]."""
    lost_unit: Bytes
    """(L,) unit of each lost beam: one with no echo of what it met. Clutter may still have given it a point."""
    lost_beam: npt.NDArray[np.int32]
    """(L,) index of the lost beam in its unit's beam table."""
    lost_cause: Bytes
    """(L,) `Loss`."""
    unit_hits: npt.NDArray[np.int32]
    """(A, U) rays of each unit that end on the actor, before any loss or noise, however near. A beam is one ray or,
    with a footprint, many."""
    unit_hits_alone: npt.NDArray[np.int32]
    """(A, U) rays that would, were it alone on the ground."""
    faces: Bytes
    """(A,) `Face` bits of the faces that returned at least `MIN_FACE_HITS` beams."""
    view: Bytes
    """(A,) `View`."""

    @property
    def hits(self) -> Ints:
        """(A,) rays of all units that end on the actor."""
        hits: Ints = self.unit_hits.sum(axis=1, dtype=np.int64)
        return hits

    @property
    def hits_alone(self) -> Ints:
        """(A,) rays of all units that would, were it alone on the ground."""
        hits: Ints = self.unit_hits_alone.sum(axis=1, dtype=np.int64)
        return hits

    @property
    def visible_fraction(self) -> Floats:
        """(A,) hits / hits_alone, 0 to 1; 0 where not even a lone actor would be met."""
        return self.hits / np.maximum(self.hits_alone, 1)
