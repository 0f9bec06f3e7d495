"""How oracles are made: one device for any number of stages."""

from collections.abc import Sequence
from dataclasses import dataclass

from scenarios.errors import DeviceError
from scenarios.oracle.oracle_tracker import OracleTracker
from scenarios.oracle.stage import Stage
from scenarios.run import device
from scenarios.run.device import DeviceFactory
from tracker.tracker import TrackerConfig


@dataclass(frozen=True, slots=True)
class OracleFactory:
    """Makes devices in which the truth replaces these stages; a `scenarios.run.device.DeviceFactory`."""

    stages: Sequence[Stage]

    def __call__(self, config: TrackerConfig) -> OracleTracker:
        """Make one.

        Raises
        ------
        DeviceError
            The settings have no such stage.
        """
        return OracleTracker(config, self.stages)

    def __str__(self) -> str:
        return f"oracle: {', '.join(stage for stage in Stage if stage in self.stages)}"


def choose(tracker: str | None, stages: Sequence[Stage]) -> DeviceFactory:
    """Return what makes the device that a command line asks for.

    Raises
    ------
    DeviceError
        It asks for stages of another tracker than the shipped one, or for one that cannot be loaded.
    """
    if not stages:
        return device.load(tracker or device.SHIPPED)
    if tracker not in (None, device.SHIPPED):
        asked = ", ".join(stages)
        raise DeviceError(
            f"--oracle {asked}: oracles replace stages of the shipped tracker, not of {tracker}; leave one of both out"
        )
    return OracleFactory(stages)
