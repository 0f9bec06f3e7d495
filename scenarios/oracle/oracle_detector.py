"""The fitting half with the truth in the place of stages."""

from scenarios.arrays import Bools, Floats, Ints
from scenarios.grading.ownership import NO_ACTOR_ROW
from scenarios.oracle import oracle_fit as fit
from scenarios.oracle import oracle_outliers, oracle_segmentation
from scenarios.oracle.oracle_truth import Truth
from scenarios.oracle.stage import Stage
from tracker.detection.deskew import Movers
from tracker.detection.detector import Detector, DetectorConfig
from tracker.merging import Pieces
from tracker.records import Boxes, Candidates, Detection, Linkage, Segments
from tracker.scan import Scan


class OracleDetector(Detector):
    """A detector that is told the truth before each scan; stages that are not replaced are the real ones."""

    truth: Truth
    """Of the scan that comes next."""
    ego_pose_odom: Floats
    """(3,) of the last scan."""
    found: Detection
    """What was found in it."""
    box_actor: Ints
    """(B,) id of the actor that each box of it was fitted to, `NO_ACTOR` where to none."""

    def __init__(self, config: DetectorConfig | None, stages: frozenset[Stage]) -> None:
        super().__init__(config)
        self._stages = stages

    def step(self, scan: Scan, movers: Movers | None = None, long: Pieces | None = None) -> Detection:
        """Fit a box to every vehicle in a scan, and remember what was found."""
        self.ego_pose_odom, self.found = scan.ego_pose_odom, super().step(scan, movers, long)
        self.box_actor = self.truth.actor_id[self.truth.owner_row(self.found.segments)[self.found.boxes.segment]]
        return self.found

    def segment(self, scan: Scan, keep: Bools, long: Pieces | None) -> Segments:
        """Group points, by the truth those on actors."""
        if Stage.SEGMENTATION not in self._stages:
            return super().segment(scan, keep, long)
        row = self.truth.point_row
        rest = super().segment(scan, keep & (row == NO_ACTOR_ROW), long)
        return oracle_segmentation.actors_first(row, keep, rest, self.config.segmentation.points_min)

    def link(self, scan: Scan, segments: Segments) -> Linkage:
        """Tell lines from outliers, those by the truth."""
        if Stage.OUTLIERS not in self._stages:
            return super().link(scan, segments)
        real, truth = super().link, self.truth
        return oracle_outliers.link(lambda clean: real(scan, clean), segments, truth.noise, truth.on_owner(segments))

    def fit(self, scan: Scan, segments: Segments, linkage: Linkage) -> Candidates:
        """Fit rectangles, and have the true ones among them."""
        gone = ~oracle_outliers.left_of((linkage.line != oracle_outliers.REMOVED) & (segments.label >= 0), segments)
        candidates = super().fit(scan, segments, oracle_outliers.stand_in(linkage, segments, gone))
        candidates = oracle_outliers.without(candidates, gone)
        if Stage.FIT not in self._stages:
            return candidates
        return fit.select(candidates, fit.rectangles(scan, segments, self.truth))

    def box(self, scan: Scan, segments: Segments, linkage: Linkage, candidates: Candidates, cut_off: Bools) -> Boxes:
        """Make boxes of rectangles, and tell that true ones are exact."""
        boxes = super().box(scan, segments, linkage, candidates, cut_off)
        return fit.made_sure(boxes, self.truth.boxed_owner(segments)) if Stage.FIT in self._stages else boxes
