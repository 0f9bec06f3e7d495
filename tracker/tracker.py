"""The tracker of the paper: scan in, tracks out. `Tracker.step` reads as its block diagram."""

from dataclasses import dataclass, field
from itertools import combinations

import numpy as np

from tracker.arrays import Bools, Floats, Ints
from tracker.detection.deskew import Movers
from tracker.detection.detector import CLOCK_DIGITS, Detector, DetectorConfig
from tracker.geometry import inside, rotate
from tracker.merging import Pieces, hull, one_vehicle
from tracker.records import Status, StepTrace, Tracks
from tracker.scan import Scan
from tracker.tracking import extent, orientation
from tracker.tracking.association import AssociationConfig, assign, score
from tracker.tracking.confirmation import TrackLifeConfig
from tracker.tracking.extent import ExtentConfig
from tracker.tracking.filters import FilterConfig, motion
from tracker.tracking.hypotheses import Hypotheses, HypothesisConfig, Predictions, pair
from tracker.tracking.mma import MmaConfig
from tracker.tracking.observations import Observations, observe
from tracker.tracking.orientation import OrientationConfig
from tracker.tracking.output import report
from tracker.tracking.track import CornerConfig, Track, TrackConfig
from tracker.tracking.track_observation import first_sighting, sighting

ROUNDS = (Status.CONFIRMED, Status.COASTING, Status.TENTATIVE)
"""Who is offered the boxes first; the list of previously confirmed tracks comes before those not yet believed."""


@dataclass(frozen=True, slots=True)
class TrackerConfig(DetectorConfig):
    """One section per stage: those of the fitting half, then those of the tracking half."""

    reading: HypothesisConfig = field(default_factory=HypothesisConfig)
    association: AssociationConfig = field(default_factory=AssociationConfig)
    filters: FilterConfig = field(default_factory=FilterConfig)
    mma: MmaConfig = field(default_factory=MmaConfig)
    extent: ExtentConfig = field(default_factory=ExtentConfig)
    orientation: OrientationConfig = field(default_factory=OrientationConfig)
    corner: CornerConfig = field(default_factory=CornerConfig)
    life: TrackLifeConfig = field(default_factory=TrackLifeConfig)


class Tracker:
    """Follows the vehicles around the ego through a sequence of scans.

    Its fitting half is `detector`, or a `Detector` of the same settings.
    """

    def __init__(self, config: TrackerConfig | None = None, detector: Detector | None = None) -> None:
        self.config = config or TrackerConfig()
        self._track_config = TrackConfig(
            filters=self.config.filters,
            mma=self.config.mma,
            extent=self.config.extent,
            orientation=self.config.orientation,
            corner=self.config.corner,
            life=self.config.life,
        )
        self._detector = detector or Detector(self.config)
        self._tracks: list[Track] = []
        self._time: float | None = None
        self._born = 0

    def step(self, scan: Scan) -> tuple[Tracks, StepTrace]:
        """Take in one scan; return the living tracks (and those that just died) and all that was between.

        A scan without points, or whose points make no vehicle (one alone, all in one place), updates nothing: tracks
        coast. Points in a row are a vehicle's side. A point whose place or time is not finite is ignored. After a gap
        between scans, tracks that have waited longer than `TrackLifeConfig` lets them are dead; the others are taken up
        again where they should be by then.

        Raises
        ------
        ValueError
            The time or the ego's pose is not finite, a field has the wrong shape or type, or the scan is not later than
            the one before. Whether it is a scan that comes late, to be left out, or the start of another recording, for
            a new tracker, only the caller can tell. The tracker stays as it was and takes the next scan.
        """
        self._detector.check(scan)
        self._predict(scan.time)
        long = [track for track in self._living if track.status is not Status.TENTATIVE and track.long]
        found = self._detector.step(scan, movers(self._living), pieces(long))
        seen = observe(found.boxes, scan.ego_pose_odom, self.config.filters)
        track_id = self._associate(seen)
        for track in self._tracks:
            track.settle()
        self._unite()
        self._exclude()
        self._start(seen, track_id, forward=float(scan.ego_pose_odom[2]))
        return report(self._tracks), StepTrace(found.segments, found.linkage, found.candidates, found.boxes, track_id)

    @property
    def _living(self) -> list[Track]:
        return [track for track in self._tracks if track.status is not Status.DEAD]

    def _predict(self, time: float) -> None:
        """Drop the dead and move the living to `time` [s]."""
        self._tracks = self._living
        dt = 0.0 if self._time is None else round(time - self._time, CLOCK_DIGITS)
        step = motion(dt, self.config.filters)
        self._time = time
        for track in self._tracks:
            track.predict(step)

    def _associate(self, seen: Observations) -> Ints:
        """Give boxes to tracks, round by round, and update them; (B,) id of each box's track, -1 for none."""
        track_id = np.full(len(seen), -1, dtype=np.int64)
        if not self._tracks or not len(seen):
            return track_id
        predictions = predict(self._tracks)
        pairing = pair(predictions, seen, self.config.reading)
        cost, in_gate = self._score(predictions, pairing, seen)
        status = np.array([track.status for track in self._tracks])
        for turn in ROUNDS:
            free = (status == turn)[:, None] & (track_id < 0)
            for t, b in assign(cost, in_gate & free, self.config.association.method):
                self._tracks[t].update(sighting(pairing, seen, t, b))
                track_id[b] = self._tracks[t].id
        return track_id

    def _score(self, predictions: Predictions, pairing: Hypotheses, seen: Observations) -> tuple[Floats, Bools]:
        """(T, B) cost of each pair of track and box, and (T, B) whether it is admissible."""
        return score(predictions, pairing, seen, self.config.association)

    def _unite(self) -> None:
        """Make one track of those that follow pieces of the same vehicle: the one that was seen more often stays."""
        fast = [t for t in self._tracks if t.seen and np.hypot(*t.velocity) >= self.config.union.speed_min_mps]
        ranked = sorted(fast, key=lambda track: (not track.sure, -track.hits))
        seen = pieces(ranked)
        for a, b in combinations(range(len(ranked)), 2):
            alive = Status.DEAD not in (ranked[a].status, ranked[b].status)
            if alive and ranked[a].sure and one_vehicle(seen, a, b, self.config.union):
                ranked[a].absorb(*hull(seen, a, b))
                ranked[b].status = Status.DEAD
                seen = pieces(ranked)

    def _exclude(self) -> None:
        """End every track whose place is taken: there is room for one vehicle, the surer, or else the older."""
        sure = [track for track in self._tracks if track.sure]
        ranked = sure + [track for track in self._tracks if not track.sure]
        corner, heading, sign = placed(ranked)
        seen_size = np.reshape([track.seen_size for track in ranked], (-1, 2))
        taken = within(corner - rotate(0.5 * sign * seen_size, heading), sure)
        for rank, track in enumerate(ranked):
            if taken[rank, :rank].any():
                track.status = Status.DEAD

    def _start(self, seen: Observations, track_id: Ints, forward: float) -> None:
        """Start a tentative track on every newcomer; its id goes to `track_id`."""
        config = self.config
        for b in np.flatnonzero(self._newcomers(seen, track_id)).tolist():
            heading, size = float(seen.heading[b]), seen.size[b]
            turns = orientation.first_guess(heading, size, seen.whole[b], forward, config.orientation)
            seen_size = orientation.turn_size(size, turns)
            usual = extent.complete(seen_size, np.zeros(2, dtype=np.int64), config.extent.car, config.extent)
            first, position = first_sighting(seen, b, turns, usual, config.reading)
            track = Track(self._born, position, first, forward, self._track_config)
            self._tracks.append(track)
            track_id[b] = self._born
            self._born += 1

    def _newcomers(self, seen: Observations, track_id: Ints) -> Bools:
        """(B,) whether a box is a vehicle not yet followed: it was given to no track, and its place is free."""
        taken = within(seen.center, [track for track in self._tracks if track.sure]).any(axis=1)
        return np.asarray((track_id < 0) & ~taken)


def within(points: Floats, tracks: list[Track]) -> Bools:
    """(P, T) whether points (P, 2) lie inside the tracks' boxes."""
    boxes = movers(tracks)
    return inside(points, boxes.center, boxes.heading, boxes.size)


def movers(tracks: list[Track]) -> Movers:
    """Where these tracks are, and how they move."""
    corner, heading, sign = placed(tracks)
    size = np.reshape([track.size for track in tracks], (-1, 2))
    velocity = np.reshape([track.velocity for track in tracks], (-1, 2))
    return Movers(corner - rotate(0.5 * sign * size, heading), heading, size, velocity)


def pieces(tracks: list[Track]) -> Pieces:
    """As far as these tracks were seen."""
    seen = [track.footprint for track in tracks]
    return Pieces(
        center=np.reshape([place.center for place in seen], (-1, 2)),
        heading=np.array([place.heading for place in seen]),
        size=np.reshape([place.size for place in seen], (-1, 2)),
        velocity=np.reshape([track.velocity for track in tracks], (-1, 2)),
        hits=np.array([track.hits for track in tracks]),
    )


def placed(tracks: list[Track]) -> tuple[Floats, Floats, Ints]:
    """Tracked corners (T, 2) [m], headings (T,), and which corners (T, 2) those are."""
    corner = np.reshape([track.position for track in tracks], (-1, 2))
    heading = np.array([track.heading for track in tracks])
    return corner, heading, np.array([track.corner_sign for track in tracks], dtype=np.int64).reshape(-1, 2)


def predict(tracks: list[Track]) -> Predictions:
    """What these tracks expect to see."""
    filters = [track.bank.filters for track in tracks]
    offset = np.array([track.offset_covariance for track in tracks])
    return Predictions(
        position=np.array([bank.mean[:, :2] for bank in filters]),
        velocity=np.array([bank.mean[:, 2:4] for bank in filters]),
        covariance=np.array([bank.covariance[:, :2, :2] for bank in filters]) + offset[:, None],
        probability=np.stack([track.bank.probability for track in tracks]),
        heading=np.array([track.heading for track in tracks]),
        heading_variance=np.array([track.yaw_state[1][0, 0] for track in tracks]),
        size=np.stack([track.size for track in tracks]),
        known_size=np.stack([track.known_size for track in tracks]),
        corner_sign=np.stack([track.corner_sign for track in tracks]),
    )
