"""Runs of `luxloop run --seeds`."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from luxloop.scenarios.commands.error_line import print_early_end, print_error
from luxloop.scenarios.errors import ContractError, Interrupted

if TYPE_CHECKING:
    from luxloop.scenarios.result import Result

BROKEN_TRACKER = 4


@dataclass(slots=True)
class SeedRuns:
    """Runs of one scenario with several seeds."""

    done: dict[int, "Result"] = field(default_factory=dict)
    """Runs with a folder, by seed."""
    errors: dict[int, str] = field(default_factory=dict)
    """Messages of the runs in which the tracker broke its contract, by seed."""
    code: int = 0
    """Exit code of the worst run."""

    @property
    def verdicts(self) -> dict[int, str]:
        """Verdict by seed, in their order."""
        found = {seed: run.verdict for seed, run in self.done.items()} | dict.fromkeys(self.errors, "broken tracker")
        return dict(sorted(found.items()))

    def document(self) -> dict[str, Any]:
        """Return the JSON document of all runs."""
        from luxloop.scenarios.report.seed_table import summary
        from luxloop.scenarios.run import run_folder

        runs = [{**run_folder.document(run, run.checks), "out": str(run.out)} for run in self.done.values()]
        errors = [{"seed": seed, "error": message} for seed, message in self.errors.items()]
        found = summary(list(self.done.values()))
        return {"exit_code": self.code, "runs": runs, "errors": errors, "summary": found}


def run_seeds(seeds: Sequence[int], run: Callable[..., "Result"], say: Callable[[str], None]) -> SeedRuns:
    """Run a scenario with each seed; a broken contract ends the run of one seed only.

    Parameters
    ----------
    seeds
        Seeds, in this order.
    run
        Runs the scenario with the argument `seed`.
    say
        Takes a line about each run that has ended.

    Raises
    ------
    Interrupted
        Ctrl-C after the first run.
    """
    found = SeedRuns()
    for seed in seeds:
        try:
            result = run(seed=seed)
        except ContractError as error:
            found.errors[seed] = str(error)
            found.code = max(found.code, print_error(f"seed {seed}: {error}", BROKEN_TRACKER))
            continue
        except KeyboardInterrupt as error:
            if not found.done:
                raise
            kept = ", ".join(map(str, found.done))
            raise Interrupted(f"interrupted at seed {seed}; the runs of seeds {kept} are kept") from error
        found.done[seed] = result
        say(f"seed {seed}: {result.verdict}; the results are in {result.out}")
        found.code = max(found.code, code_of(result))
    return found


def code_of(result: "Result") -> int:
    """Return the exit code of a run, and print why it ended early, if it did."""
    from luxloop.scenarios.files.expect import exit_code

    if not result.complete:
        return print_early_end(result, f"the {result.frames} frames until then are in {result.out}, marked incomplete")
    return exit_code(result.verdict)
