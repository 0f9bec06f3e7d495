"""The tracker of the paper: scan in, tracks out. `Tracker.step` reads as its block diagram."""

from dataclasses import dataclass, field

import numpy as np

from tracker import boxes, ends, extent, orientation, preprocess, rectangles, segmentation, selection, tlinkage, union
from tracker.association import AssociationConfig, Pairing, Predictions, assign, pair, score
from tracker.background import Background, BackgroundConfig
from tracker.boxes import BoxConfig
from tracker.ends import EndConfig
from tracker.extent import ExtentConfig
from tracker.filters import FilterConfig, motion
from tracker.geometry import QUARTER, inside, rotate, wrap
from tracker.mma import MmaConfig
from tracker.observations import Observations, observe
from tracker.orientation import OrientationConfig
from tracker.preprocess import PreprocessConfig
from tracker.records import Bools, Floats, Ints, Segments, Status, StepTrace, Tracks
from tracker.rectangles import RectangleConfig
from tracker.report import report
from tracker.scan import Scan
from tracker.segmentation import SegmentationConfig
from tracker.selection import SelectionConfig
from tracker.shadow import ShadowConfig, in_shadow
from tracker.sweep import EgoMotion, Movers, SweepConfig, undo_targets
from tracker.tlinkage import LinkageConfig
from tracker.track import LifeConfig, Track, TrackConfig
from tracker.union import Pieces, UnionConfig, hull, one_vehicle

ROUNDS = (Status.CONFIRMED, Status.COASTING, Status.TENTATIVE)
"""Who is offered the boxes first; the list of previously confirmed tracks comes before those not yet believed."""

CLOCK_DIGITS = 9
"""Scans are told apart to the nanosecond; the rest of a difference of times is rounding."""


@dataclass(frozen=True, slots=True)
class TrackerConfig:
    """One section per stage."""

    preprocess: PreprocessConfig = field(default_factory=PreprocessConfig)
    sweep: SweepConfig = field(default_factory=SweepConfig)
    segmentation: SegmentationConfig = field(default_factory=SegmentationConfig)
    background: BackgroundConfig = field(default_factory=BackgroundConfig)
    union: UnionConfig = field(default_factory=UnionConfig)
    ends: EndConfig = field(default_factory=EndConfig)
    linkage: LinkageConfig = field(default_factory=LinkageConfig)
    rectangles: RectangleConfig = field(default_factory=RectangleConfig)
    selection: SelectionConfig = field(default_factory=SelectionConfig)
    boxes: BoxConfig = field(default_factory=BoxConfig)
    shadow: ShadowConfig = field(default_factory=ShadowConfig)
    association: AssociationConfig = field(default_factory=AssociationConfig)
    filters: FilterConfig = field(default_factory=FilterConfig)
    mma: MmaConfig = field(default_factory=MmaConfig)
    extent: ExtentConfig = field(default_factory=ExtentConfig)
    orientation: OrientationConfig = field(default_factory=OrientationConfig)
    life: LifeConfig = field(default_factory=LifeConfig)


class Tracker:
    """Follows the vehicles around the ego through a sequence of scans."""

    def __init__(self, config: TrackerConfig | None = None) -> None:
        self.config = config or TrackerConfig()
        self._track_config = TrackConfig(
            filters=self.config.filters,
            mma=self.config.mma,
            extent=self.config.extent,
            orientation=self.config.orientation,
            life=self.config.life,
        )
        self._ego_motion = EgoMotion(self.config.sweep)
        self._background = Background(self.config.background)
        self._tracks: list[Track] = []
        self._time: float | None = None
        self._born = 0

    def step(self, scan: Scan) -> tuple[Tracks, StepTrace]:
        """Take in one scan; return the living tracks (and those that just died) and all that was between."""
        config = self.config
        keep = preprocess.keep(scan, config.preprocess)
        swept, scan = scan, self._ego_motion.undo(scan)
        segments = segmentation.segment(scan.points_ego, keep, config.segmentation)
        segments = self._background.remove(into_odom(scan), segments)
        self._predict(scan.time)
        segments = self._claim(scan, segments)
        scan = undo_targets(scan, segments, movers(self._tracks), config.sweep)
        cut_off = ends.cut_off(swept, keep, segments, config.ends)
        linkage = tlinkage.link(scan.points_ego, segments, config.linkage)
        found = rectangles.fit(scan.points_ego, segments, linkage, config.rectangles)
        candidates = selection.select(scan.points_ego, segments, linkage, found, config.selection)
        fitted = boxes.build(scan.points_ego, scan.time_offset, segments, linkage, candidates, cut_off, config.boxes)
        fitted = fitted.subset(~in_shadow(fitted, config.shadow))

        seen = observe(fitted, scan.ego_pose_odom, config.filters)
        track_id = self._associate(seen)
        for track in self._tracks:
            track.settle()
        self._unite()
        self._exclude()
        self._start(seen, track_id, forward=float(scan.ego_pose_odom[2]))
        return report(self._tracks), StepTrace(segments, linkage, candidates, fitted, track_id)

    def _predict(self, time: float) -> None:
        """Drop the dead and move the living to `time` [s]."""
        self._tracks = [track for track in self._tracks if track.status is not Status.DEAD]
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
        pairing = pair(predictions, seen, self.config.association)
        cost, in_gate = score(predictions, pairing, self.config.association)
        status = np.array([track.status for track in self._tracks])
        for turn in ROUNDS:
            free = (status == turn)[:, None] & (track_id < 0)
            for t, b in assign(cost, in_gate & free):
                update(self._tracks[t], pairing, seen, t, b)
                track_id[b] = self._tracks[t].id
        return track_id

    def _claim(self, scan: Scan, segments: Segments) -> Segments:
        """Put the pieces of each vehicle that is longer than a car together; cars are seen in one."""
        long = [t for t in self._tracks if t.status is not Status.TENTATIVE and t.long]
        return union.claim(into_odom(scan), segments, pieces(long), self.config.union) if long else segments

    def _unite(self) -> None:
        """Make one track of those that follow pieces of the same vehicle: the one that was seen more often stays."""
        ranked = sorted((t for t in self._tracks if t.seen), key=lambda t: (not t.sure, -t.hits))
        for rank, a in enumerate(ranked):
            for b in ranked[rank + 1 :] if a.sure else ():
                both = pieces([a, b])
                if Status.DEAD not in (a.status, b.status) and one_vehicle(both, 0, 1, self.config.union):
                    a.absorb(*hull(both, 0, 1))
                    b.status = Status.DEAD

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
        """Start a tentative track on every box that has none, in a place that is free; its id goes to `track_id`."""
        taken = within(seen.center, [track for track in self._tracks if track.sure]).any(axis=1)
        for b in np.flatnonzero((track_id < 0) & ~taken):
            heading, size = float(seen.heading[b]), seen.size[b]
            turns = orientation.first_guess(heading, size, seen.whole[b], forward, self.config.orientation)
            track = Track(
                track_id=self._born,
                position=seen.corner[b],
                heading=wrap(heading + turns * QUARTER),
                size=orientation.turn_size(size, turns),
                corner_sign=orientation.turn_sign(seen.corner_sign[b], turns),
                covariance=seen.covariance[b],
                sight=extent.is_vehicle(size, seen.whole[b], size, self.config.extent),
                forward=forward,
                config=self._track_config,
            )
            self._tracks.append(track)
            track_id[b] = self._born
            self._born += 1


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


def into_odom(scan: Scan) -> Floats:
    """(N, 2) points of the scan in the odometry frame [m]."""
    return rotate(scan.points_ego[:, :2], scan.ego_pose_odom[2]) + scan.ego_pose_odom[:2]


def predict(tracks: list[Track]) -> Predictions:
    """What these tracks expect to see."""
    return Predictions(
        position=np.array([[kf.x[:2] for kf in track.bank.models] for track in tracks]),
        velocity=np.array([track.bank.velocity for track in tracks]),
        covariance=np.array([[kf.P[:2, :2] for kf in track.bank.models] for track in tracks]),
        probability=np.stack([track.model_probability for track in tracks]),
        heading=np.array([track.heading for track in tracks]),
        size=np.stack([track.size for track in tracks]),
        known_size=np.stack([track.known_size for track in tracks]),
        corner_sign=np.stack([track.corner_sign for track in tracks]),
    )


def update(track: Track, pairing: Pairing, seen: Observations, t: int, b: int) -> None:
    """Hand box `b`, read as an observation of track `t`, to that track."""
    track.update(
        misfit=pairing.misfit[t, b],
        heading=float(pairing.heading[t, b]),
        size=pairing.size[t, b],
        whole=pairing.whole[t, b],
        flat=bool(seen.flat[b]),
        covariance=pairing.covariance[t, b] + pairing.silence[t, b],
        heading_variance=float(seen.covariance[b, 2, 2]),
        corner_sign=pairing.corner_sign[t, b],
    )
