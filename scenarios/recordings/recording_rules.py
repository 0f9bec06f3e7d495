"""Settings of a tracker and of grading on a recording."""

from dataclasses import dataclass, field, replace

import numpy as np

from luxloop.scenarios.files import shipped
from luxloop.scenarios.files.expect import Limit
from luxloop.scenarios.files.scenario import Scenario
from luxloop.scenarios.grading.grading_config import GradingConfig
from luxloop.scenarios.recordings.recording import Recording
from luxloop.tracker.tracker import TrackerConfig

USUAL_PERIOD_S = 0.08
"""[s] Scan period for which the defaults of the tracker are meant, that of the LUX at 12.5 Hz."""


@dataclass(frozen=True, slots=True)
class Rules:
    """Settings of a run over a recording."""

    tracker: TrackerConfig = field(default_factory=TrackerConfig)
    grading: GradingConfig = field(default_factory=GradingConfig)
    expect: dict[str, Limit] = field(default_factory=dict)


def rules_of(recording: Recording, scenario: str | None) -> Rules:
    """Return the settings of a scenario, by name or path, or the defaults for the scan period of a recording.

    Raises
    ------
    ScenarioError
        The scenario does not exist, or is invalid.
    """
    if scenario is None:
        return Rules(_for_period(TrackerConfig(), recording))
    chosen = Scenario.load(shipped.find(scenario))
    return Rules(chosen.tracker, chosen.grading, chosen.expect)


def _for_period(config: TrackerConfig, recording: Recording) -> TrackerConfig:
    """Return settings in which a tentative and a confirmed track survive as many missed scans as at the usual period.

    Both limits are times. At 4 Hz the default of tentative tracks is shorter than one scan period, and none would
    survive a missed scan.
    """
    period_s = float(np.median(np.diff(recording.time_s))) if len(recording) > 1 else USUAL_PERIOD_S
    factor = max(1.0, period_s / USUAL_PERIOD_S)
    confirmation = replace(
        config.confirmation,
        tentative_coast_s=factor * config.confirmation.tentative_coast_s,
        gap_s=factor * config.confirmation.gap_s,
    )
    return replace(config, confirmation=confirmation)
