"""Ground truth of a scan, hidden from the tracker: origin of each point, and visibility of each actor."""

from dataclasses import dataclass
from enum import IntEnum, IntFlag

import numpy as np
import numpy.typing as npt

from luxloop.arrays import Bytes, Floats, Ints

NO_ACTOR = -1
"""`ScanTruth.actor_id` of points that are not on an actor."""


class Part(IntEnum):
    """Part that a beam hit."""

    NONE = 0
    GROUND = 1
    OBSTACLE = 2
    BODY = 3
    GREENHOUSE = 4
    """A pane of glass."""
    MIRROR = 5
    WHEEL = 6
    INTERIOR = 7
    """Interior behind a pane."""
    DROPLET = 8
    """Rain, spray, snow or fog."""


class Cause(IntEnum):
    """Cause of a point's position. Outlier removal should find all but CLEAN points."""

    CLEAN = 0
    MIRROR = 1
    """On a side mirror of a vehicle."""
    LAYER_OVERLAP = 2
    """On a part well inside the vehicle's outline, such as the window behind the deck or a wheel under the bumper."""
    RANGE_OUTLIER = 3
    """The unit measured a wrong range."""
    GHOST = 4
    """Specular reflection: the object hit appears behind the mirror."""
    DOUBLED = 5
    """On an actor seen by several units, displaced by calibration or timing errors."""
    FALSE_ALARM = 6
    """False alarm of the detector."""
    RAIN = 7
    """On a raindrop."""
    SPRAY = 8
    """On spray of a vehicle."""
    SNOW = 9
    """On a snowflake."""
    FOG = 10
    """On fog."""


ON_NOTHING = (Cause.GHOST, Cause.FALSE_ALARM, Cause.RAIN, Cause.SPRAY, Cause.SNOW, Cause.FOG)
"""Causes of points that lie neither on an actor nor on an obstacle."""


class Loss(IntEnum):
    """Cause of a beam without an echo of the object it hit."""

    THRESHOLD = 0
    """The echo was too weak."""
    RANDOM = 1
    """Random loss of the detector."""
    OUTAGE = 2
    """The unit was silent."""
    DIRT = 3
    """Attenuation by dirt on the unit's window."""
    SUN = 4
    """Reduced sensitivity by sun glare."""
    AIR = 5
    """Attenuation by rain, snow or fog."""
    TOO_NEAR = 6
    """All hits are nearer than the minimum range of the unit."""


class Face(IntFlag):
    """Faces of a vehicle's outline."""

    FRONT = 1
    LEFT = 2
    REAR = 4
    RIGHT = 8


class View(IntEnum):
    """Visible part of a vehicle's outline (table 1 of the paper)."""

    NONE = 0
    L_SHAPE = 1
    SIDE = 2
    REAR = 3
    FRONT = 4


@dataclass(frozen=True, slots=True, eq=False)
class ScanTruth:
    """Ground truth of a `Scan` of N points, for the frame's A actors in the order of `WorldFrame.actors`."""

    actor_id: Ints
    """(N,) actor that the point is on, or `NO_ACTOR`."""
    part: Bytes
    """(N,) `Part`."""
    cause: Bytes
    """(N,) `Cause`."""
    true_range: npt.NDArray[np.float32]
    """(N,) range without noise [m]."""
    lost_unit: Bytes
    """(L,) unit of each lost beam, which has no echo of the object it hit. It may have a point from clutter."""
    lost_beam: npt.NDArray[np.int32]
    """(L,) index of the lost beam in its unit's beam table."""
    lost_cause: Bytes
    """(L,) `Loss`."""
    unit_hits: npt.NDArray[np.int32]
    """(A, U) rays of each unit that end on the actor, at any range, before losses and noise. A beam is one ray, or many
    with a footprint."""
    unit_hits_alone: npt.NDArray[np.int32]
    """(A, U) rays that would end on the actor if it were alone on the ground."""
    faces: Bytes
    """(A,) `Face` bits of the faces with at least `MIN_FACE_HITS` points."""
    view: Bytes
    """(A,) `View`."""

    @property
    def hits(self) -> Ints:
        """(A,) rays of all units that end on the actor."""
        hits: Ints = self.unit_hits.sum(axis=1, dtype=np.int64)
        return hits

    @property
    def hits_alone(self) -> Ints:
        """(A,) rays of all units that would end on the actor if it were alone on the ground."""
        hits: Ints = self.unit_hits_alone.sum(axis=1, dtype=np.int64)
        return hits

    @property
    def visible_fraction(self) -> Floats:
        """(A,) hits / hits_alone, 0 to 1; 0 if no ray would hit the actor alone."""
        return self.hits / np.maximum(self.hits_alone, 1)
