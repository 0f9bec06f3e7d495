"""One run from file to folder: what `luxloop run`, pytest, blame and sweeps have in common."""

from collections.abc import Sequence
from contextlib import nullcontext
from dataclasses import dataclass
from pathlib import Path

from rich.console import RenderableType

from scenarios import dataset, loop, report, run_folder
from scenarios.device import DeviceFactory
from scenarios.expect import Check, Verdict, check, verdict
from scenarios.result import Result
from scenarios.scenario import Scenario


@dataclass(frozen=True, slots=True)
class Outcome:
    """A run that is on disk."""

    result: Result
    checks: list[Check]
    report: RenderableType
    """What a person reads of it."""
    out: Path
    """Its folder."""

    @property
    def verdict(self) -> Verdict:
        """Whether it did what was expected of it."""
        return verdict(self.checks, self.result.complete)


def usual_folder(scenario: Scenario, oracles: Sequence[str] = (), runs: Path = Path("runs")) -> Path:
    """Where a run goes if nobody says otherwise; one with oracles does not replace the tracker's own."""
    oracle = ["oracle", *oracles] if oracles else []
    return runs / "-".join([f"{scenario.name}-seed{scenario.seed}", *oracle])


def execute(
    scenario: Scenario,
    make_device: DeviceFactory,
    out: Path,
    *,
    record: bool = True,
    dataset_to: Path | None = None,
) -> Outcome:
    """Run a scenario, grade it, and write its folder.

    Parameters
    ----------
    scenario, make_device
        As `scenarios.loop.run`.
    out
        The folder; an earlier run there is replaced.
    record
        Whether to write a recording.
    dataset_to
        Folder of a data set, see `scenarios.dataset`.

    Raises
    ------
    OutputError
        A folder cannot be written, or must stay.
    Exception
        As `scenarios.loop.run`; then nothing is written.
    """
    with run_folder.create(out) as folder, dataset.create(dataset_to, out) if dataset_to else nullcontext() as writer:
        record_to = folder / run_folder.RECORDING if record else None
        result = loop.run(scenario, make_device, record_to, writer.add if writer else None)
        checks = check(result.metrics, scenario.expect)
        printed = report.report(result, checks)
        run_folder.write(folder, result, checks, report.as_text(printed))
        if writer:
            writer.finish(result)
    return Outcome(result, checks, printed, out)
