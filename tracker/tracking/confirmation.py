"""Track confirmation: by the shape of the visible sides, or by leaving the place of the first observation."""

from dataclasses import dataclass

import numpy as np

from tracker.arrays import Floats
from tracker.tracking import extent
from tracker.tracking.extent import ExtentConfig
from tracker.tracking.footprint import Footprint
from tracker.tracking.track_observation import TrackObservation


@dataclass(frozen=True, slots=True)
class TrackLifeConfig:
    """Track confirmation, coasting and termination."""

    confirm_hits: int = 4
    """Observations before a track that left its first place is confirmed."""
    evidence_min: int = 8
    """Evidence of a vehicle's shape (`extent.evidence`) that confirms a track without motion: two full views, or more
    partial ones."""
    sure_hits: int = 2
    """Minimum number of observations for confirmation by shape."""
    tentative_coast_s: float = 0.2
    """A tentative track is terminated when it was not seen for longer than this [s]."""
    gap_s: float = 0.25
    """A confirmed track stays confirmed through gaps up to this length [s] and coasts after it."""
    coast_s: float = 3.0
    """A confirmed track coasts for this long before it is terminated [s]."""
    coast_std_max_m: float = 3.0
    """A coasting track is terminated earlier if its position has a larger standard deviation [m]."""
    heading_gate_sigma: float = 4.0
    """Gate on the heading innovation, in standard deviations."""
    heading_rejections_max: int = 8
    """Number of rejected headings in a row after which the next one is accepted."""


class Confirmation:
    """Evidence that one track is a vehicle."""

    def __init__(self, config: TrackLifeConfig, sizes: ExtentConfig, birthplace: Footprint) -> None:
        self._config = config
        self._sizes = sizes
        self._birthplace = birthplace
        self._left = False
        self._evidence = [0, 0]
        """Evidence before and after more than a car's length was seen."""
        self._piece_evidence, self._piece_length = 0, 0.0
        """Evidence of views that may be pieces of a wall, and the length of the longest of them [m]."""

    def holds(self, hits: int, seen_size: Floats) -> bool:
        """Return True if the track is a vehicle, after `hits` observations of seen extents (2,) [m]."""
        pieces = self._piece_evidence if extent.car_sized(seen_size, self._sizes) else 0
        if self._evidence[extent.long(seen_size, self._sizes)] + pieces >= self._config.evidence_min:
            return hits >= self._config.sure_hits
        return self._left and hits >= self._config.confirm_hits

    def count(self, seen: TrackObservation, seen_size: Floats) -> None:
        """Count an observation as evidence for or against a vehicle with seen extents (2,) [m].

        A single side that becomes longer was truncated before: the evidence of such pieces is discarded.
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

    def check_motion(self, seen: TrackObservation, footprint: Footprint) -> None:
        """Check if the track has left its birthplace.

        A single truncated face seems to slide along itself when its occluder moves, so only its motion across counts.
        """
        fixed = seen.whole | (seen.size[::-1] > self._sizes.face_min_m)
        self._left |= bool(np.any(fixed & footprint.clear_of(self._birthplace)))
