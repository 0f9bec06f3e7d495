"""Choice of the device under test by command line options."""

from collections.abc import Sequence
from dataclasses import dataclass

from luxloop.scenarios.errors import DeviceError
from luxloop.scenarios.oracle.oracle_tracker import OracleTracker
from luxloop.scenarios.oracle.stage import Stage
from luxloop.scenarios.run import device
from luxloop.scenarios.run.device import DeviceFactory
from luxloop.tracker.tracker import TrackerConfig


@dataclass(frozen=True, slots=True)
class OracleFactory:
    """Factory of trackers with oracles for these stages; a `luxloop.scenarios.run.device.DeviceFactory`."""

    stages: Sequence[Stage]

    def __call__(self, config: TrackerConfig) -> OracleTracker:
        """Return a new tracker.

        Raises
        ------
        DeviceError
            The settings have no such stage.
        """
        return OracleTracker(config, self.stages)

    def __str__(self) -> str:
        return f"oracle: {', '.join(stage for stage in Stage if stage in self.stages)}"


def choose(tracker: str | DeviceFactory | None, stages: Sequence[Stage]) -> DeviceFactory:
    """Return the factory of the device under test: a tracker, or the shipped one with oracles for some stages.

    Raises
    ------
    DeviceError
        Oracles are combined with another tracker than the shipped one, or the tracker cannot be loaded.
    """
    if not stages:
        return device.factory_of(tracker)
    if tracker not in (None, device.SHIPPED):
        asked, tracker = ", ".join(stages), tracker if isinstance(tracker, str) else device.name_of(tracker)
        raise DeviceError(
            f"--oracle {asked}: oracles replace stages of the shipped tracker, not of {tracker}; "
            "omit --oracle or --tracker"
        )
    return OracleFactory(stages)
