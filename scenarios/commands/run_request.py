"""Options of one `luxloop run`."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

from luxloop.scenarios.commands.arguments import cores, overrides
from luxloop.scenarios.errors import InputError

if TYPE_CHECKING:
    from luxloop.scenarios.execute import ExecutedRun
    from luxloop.scenarios.files.scenario import Scenario
    from luxloop.scenarios.oracle.stage import Stage
    from luxloop.scenarios.run.device import DeviceFactory


@dataclass(frozen=True)
class RunRequest:
    """Options of `luxloop run`, apart from seeds and output."""

    scenario: str
    duration_s: float | None
    settings: Sequence[str]
    out: Path | None
    tracker: str | None
    stages: "Sequence[Stage]"
    record: bool
    record_scans: bool
    dataset_to: Path | None
    step_timeout_s: float
    ahead: bool | None
    """True to run traffic and LIDARs in a process of their own; None does so if there is a second core."""

    @cached_property
    def device(self) -> "DeviceFactory":
        """The device under test, loaded once.

        Raises
        ------
        DeviceError
            It cannot be loaded.
        """
        from luxloop.scenarios.oracle.device_choice import choose

        return choose(self.tracker, self.stages)

    def load(self, seed: int | None) -> "Scenario":
        """Return the scenario with the options' keys.

        Raises
        ------
        InputError
            The file or a key is invalid.
        """
        from luxloop.scenarios.files import shipped, toml_file

        path = shipped.find(self.scenario)
        toml_file.read(path)  # reports a misspelt name or invalid TOML before the slow imports
        from luxloop.scenarios.files.scenario import Scenario

        return Scenario.load(path, overrides(seed, self.duration_s), self.settings)

    def require_own_folders(self) -> None:
        """Check that several runs do not write to one folder.

        Raises
        ------
        InputError
            A data set was asked for.
        """
        if self.dataset_to:
            raise InputError("--seeds and --dataset are both given; omit one, a data set is of one run")

    def execute(self, seed: int | None, *, several: bool = False) -> "ExecutedRun":
        """Run the scenario with a seed; one of several runs gets a folder inside `--out`.

        Raises
        ------
        Exception
            As `luxloop.scenarios.execute.execute`.
        """
        ahead = cores() > 1 if self.ahead is None else self.ahead
        if ahead:
            self._start_ahead()
        scenario = self.load(seed)
        from luxloop.scenarios.execute import default_folder, execute

        device = self.device
        default = default_folder(scenario, self.stages, self.tracker)
        return execute(
            scenario,
            device,
            self.out / default.name if self.out and several else self.out or default,
            record=self.record,
            record_scans=self.record_scans,
            dataset_to=self.dataset_to,
            step_timeout_s=self.step_timeout_s,
            ahead=ahead,
        )

    def _start_ahead(self) -> None:
        """Let the process of traffic and LIDARs import its modules, which take a second, while this one does."""
        from luxloop.scenarios.files import shipped, toml_file

        toml_file.read(shipped.find(self.scenario))  # a misspelt name needs no process
        from luxloop.sim.process.process_source import start_early

        start_early("luxloop.scenarios.run.scan_source")
