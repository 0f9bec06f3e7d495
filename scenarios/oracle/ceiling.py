"""The ceiling of a scenario: HOTA of a tracker beside that of an ideal causal tracker on the same scans."""

from collections.abc import Sequence
from dataclasses import asdict, dataclass

from luxloop.scenarios.files.scenario import Scenario
from luxloop.scenarios.grading.body_points import Ranging
from luxloop.scenarios.grading.frame_truth import FrameGrade
from luxloop.scenarios.oracle.ceiling_tracker import CeilingFactory, PoseNoise
from luxloop.scenarios.oracle.stage_blame import ParallelDevice
from luxloop.scenarios.run import loop
from luxloop.scenarios.run.device import DeviceFactory
from luxloop.sensor_model.rig.rig import load_rig
from luxloop.sensor_model.truth import ScanTruth
from luxloop.sim.world import WorldFrame
from luxloop.tracker.scan import Scan
from luxloop.tracker.tracker import Tracker

HOTA = "track.hota"
EXACT = PoseNoise(0.0, 0.0)


@dataclass(frozen=True, slots=True)
class Ceiling:
    """HOTA of one run, and what its scans allow. Values are None if no vehicle was graded."""

    scenario: str
    seed: int
    trace_hash: str
    """Of the tracker's run."""
    frames: int
    ended_early: str
    """Reason if the traffic ended before the last frame."""
    hota: float | None
    """Of the tracker."""
    exact: float | None
    """Of an ideal causal tracker with true poses."""
    noisy: float | None
    """Of the same with errors of the poses."""

    @property
    def lost_by_scans(self) -> float | None:
        """Loss by late starts and unseen ends, which no tracker avoids."""
        return difference(1.0, self.exact)

    @property
    def lost_by_noise(self) -> float | None:
        """Loss by the stated errors of the poses."""
        return difference(self.exact, self.noisy)

    @property
    def lost_by_tracker(self) -> float | None:
        """Loss of the tracker against the ideal one with noise."""
        return difference(self.noisy, self.hota)

    @property
    def losses(self) -> dict[str, float | None]:
        """The three losses by name."""
        return {"scans": self.lost_by_scans, "noise": self.lost_by_noise, "tracker": self.lost_by_tracker}

    @property
    def data(self) -> dict[str, object]:
        """All values for JSON."""
        return {**asdict(self), "losses": self.losses}


def difference(more: float | None, less: float | None) -> float | None:
    """Return the difference of two values, None if one is missing."""
    return None if more is None or less is None else more - less


def measure(scenario: Scenario, noise: PoseNoise, make_tracker: DeviceFactory = Tracker) -> Ceiling:
    """Run a tracker, and grade two ideal causal trackers on its scans, also if its tracks drive the ego."""
    ranging = Ranging.of(load_rig(str(scenario.rig), scenario.folder), scenario.noise)
    ideal = [
        ParallelDevice(scenario, CeilingFactory(scenario.grading, ranging, errors, scenario.seed))
        for errors in (EXACT, noise)
    ]

    def add(frame: WorldFrame, scan: Scan, truth: ScanTruth, _: FrameGrade) -> None:
        for one in ideal:
            one.add(frame, scan, truth)

    result = loop.run(scenario, make_tracker, export=add)
    exact, noisy = (one.finish()[0][HOTA].value for one in ideal)
    return Ceiling(
        result.scenario,
        result.seed,
        result.trace_hash,
        result.frames,
        result.ended_early,
        result.metrics[HOTA].value,
        exact,
        noisy,
    )


def mean(ceilings: Sequence[Ceiling], name: str) -> float | None:
    """Return the mean of a value over the runs that have it, None if none has."""
    found = [value for one in ceilings if (value := getattr(one, name)) is not None]
    return sum(found) / len(found) if found else None
