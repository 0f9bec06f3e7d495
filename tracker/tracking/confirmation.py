"""Whether a track is a vehicle's: by what its sides show, or by having left the place where it was first seen."""

from dataclasses import dataclass

import numpy as np

from tracker.arrays import Floats
from tracker.tracking import extent
from tracker.tracking.extent import ExtentConfig
from tracker.tracking.footprint import Footprint
from tracker.tracking.track_observation import TrackObservation


@dataclass(frozen=True, slots=True)
class TrackLifeConfig:
    """When a track is believed and when it is given up."""

    confirm_hits: int = 4
    """Observations before a track that left its place is confirmed."""
    evidence_min: int = 8
    """Evidence of a vehicle's sides (`extent.evidence`) that does without motion: two full views, or more lesser ones,
    but ..."""
    sure_hits: int = 2
    """... never fewer observations than this."""
    tentative_coast_s: float = 0.2
    """A tentative track dies when not seen for longer than this [s]."""
    gap_s: float = 0.25
    """A confirmed track stays so through gaps this short [s]; longer ones make it coast."""
    coast_s: float = 3.0
    """A confirmed track waits this long for re-association [s]."""
    coast_std_max_m: float = 3.0
    """It is given up earlier when its position is no better known than this [m]."""
    heading_gate_sigma: float = 4.0
    """A measured heading farther off than this is not believed ..."""
    heading_rejections_max: int = 8
    """... unless it comes this often in a row."""


class Confirmation:
    """What has been seen of one track that speaks for a vehicle."""

    def __init__(self, config: TrackLifeConfig, sizes: ExtentConfig, birthplace: Footprint) -> None:
        self._config = config
        self._sizes = sizes
        self._birthplace = birthplace
        self._left = False
        self._evidence = [0, 0]
        """For a vehicle, before and after more than a car's length was seen."""
        self._piece_evidence, self._piece_length = 0, 0.0
        """The same of sights that might be pieces of a wall, and how long the longest of them is [m]."""

    def holds(self, hits: int, seen_size: Floats) -> bool:
        """Whether this is a vehicle, of which (2,) was seen in so many observations [m]."""
        pieces = self._piece_evidence if extent.car_sized(seen_size, self._sizes) else 0
        if self._evidence[extent.long(seen_size, self._sizes)] + pieces >= self._config.evidence_min:
            return hits >= self._config.sure_hits
        return self._left and hits >= self._config.confirm_hits

    def see(self, seen: TrackObservation, seen_size: Floats) -> None:
        """Count an observation for or against a vehicle of which (2,) was seen so far [m].

        A side alone that gets longer was not seen as a whole before: what such pieces said is lost.
        """
        length, long = float(seen.size.max()), extent.long(seen_size, self._sizes)
        weight = extent.evidence(seen.size, seen.whole, np.maximum(seen_size, seen.size), self._sizes)
        vote = weight - seen.flat
        if extent.is_piece(seen.size, seen.whole, self._sizes) and not long:
            if weight == extent.ONE_SIDE:
                if length > self._piece_length + self._sizes.grown_min_m:
                    self._piece_evidence = 0
                self._piece_length = max(length, self._piece_length)
            self._piece_evidence += vote
        else:
            self._evidence[long] += vote

    def go(self, seen: TrackObservation, footprint: Footprint) -> None:
        """Look whether it has left its place.

        A bare face that is cut off slides along itself as what hides it moves; across itself it is where it is.
        """
        fixed = seen.whole | (seen.size[::-1] > self._sizes.face_min_m)
        self._left |= bool(np.any(fixed & footprint.clear_of(self._birthplace)))
