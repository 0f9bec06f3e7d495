"""Detection with oracles in place of stages."""

from luxloop.scenarios.arrays import Bools
from luxloop.scenarios.grading.ownership import NO_ACTOR_ROW
from luxloop.scenarios.oracle import oracle_fit as fit
from luxloop.scenarios.oracle import oracle_outliers, oracle_segmentation
from luxloop.scenarios.oracle.oracle_context import OracleContext
from luxloop.scenarios.oracle.oracle_truth import Truth
from luxloop.scenarios.oracle.stage import Stage
from luxloop.tracker.detection.detector import Detector, DetectorConfig
from luxloop.tracker.records import Boxes, Candidates, Detection, Linkage, OrientedBoxes, SegmentedPoints, Segments
from luxloop.tracker.scan import Scan


class OracleDetector(Detector):
    """A detector that knows the ground truth of each scan. Stages without an oracle are those of `Detector`."""

    def __init__(self, config: DetectorConfig | None, stages: frozenset[Stage], context: OracleContext) -> None:
        super().__init__(config)
        self._stages = stages
        self._context = context

    @property
    def truth(self) -> Truth:
        """Ground truth of the current scan."""
        return self._context.truth

    def step(self, scan: Scan, movers: OrientedBoxes | None = None, long: OrientedBoxes | None = None) -> Detection:
        """Detect the vehicles in a scan and record the owners of their boxes."""
        found = super().step(scan, movers, long)
        self._context.add_detection(scan.ego_pose_odom, found)
        return found

    def segment(self, scan: Scan, keep: Bools, long: OrientedBoxes | None) -> Segments:
        """Group points, those on actors by the ground truth."""
        if Stage.SEGMENTATION not in self._stages:
            return super().segment(scan, keep, long)
        row = self.truth.point_row
        rest = super().segment(scan, keep & (row == NO_ACTOR_ROW), long)
        return oracle_segmentation.actors_first(row, keep, rest, self.config.segmentation.points_min)

    def link(self, points: SegmentedPoints) -> Linkage:
        """Separate lines from outliers, the outliers by the ground truth."""
        if Stage.OUTLIERS not in self._stages:
            return super().link(points)
        real, truth = super().link, self.truth
        return oracle_outliers.link(real, points, truth.noise, truth.on_owner(points.segments))

    def fit(self, points: SegmentedPoints, linkage: Linkage) -> Candidates:
        """Fit rectangles and add the true ones."""
        segments = points.segments
        gone = ~oracle_outliers.has_points((linkage.line != oracle_outliers.REMOVED) & (segments.label >= 0), segments)
        candidates = super().fit(points, oracle_outliers.with_placeholder_lines(linkage, segments, gone))
        candidates = oracle_outliers.without_rectangles(candidates, gone)
        if Stage.FIT not in self._stages:
            return candidates
        return fit.select(candidates, fit.rectangles(points, self.truth))

    def box(self, points: SegmentedPoints, linkage: Linkage, candidates: Candidates) -> Boxes:
        """Make boxes of rectangles; true rectangles get a small covariance."""
        boxes = super().box(points, linkage, candidates)
        exact = Stage.FIT in self._stages
        return fit.with_exact(boxes, self.truth.boxed_owner(points.segments)) if exact else boxes
