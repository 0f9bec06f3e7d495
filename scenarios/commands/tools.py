"""Tools: `luxloop check-tracker`, `warm-up` and `schema`."""

from typing import Annotated

import typer

from luxloop.printable import print_text
from luxloop.scenarios.commands.arguments import Quiet, ScenarioName, Tracker
from luxloop.scenarios.errors import DeviceError


def check_tracker(
    tracker: Annotated[str, typer.Argument(metavar="MODULE:NAME", help="A tracker, as for `luxloop run --tracker`.")],
) -> None:
    """Check that a tracker keeps the interface contract, with real and degenerate scans."""
    from luxloop.scenarios.check_tracker.check_drives import drives
    from luxloop.scenarios.check_tracker.sequence_checks import checks_document, examine, examine_apart
    from luxloop.scenarios.report import text
    from luxloop.scenarios.run import device
    from luxloop.scenarios.run.process_tracker import ClassFactory, ProcessFactory

    chosen = device.load(tracker)
    if isinstance(chosen, ProcessFactory):
        raise DeviceError(f"{tracker}: give a class or function; luxloop run checks the answers of a program")
    findings = examine_apart(chosen.spec, drives()) if isinstance(chosen, ClassFactory) else examine(chosen, drives())
    text.show(checks_document(findings, tracker))
    raise typer.Exit(0 if findings.passed else 1)


SCENARIO = "sumo-crossing"
"""Uses the kernels of traffic, sensor and tracker."""
SIMULATED_S = 0.8
"""Long enough for tracks."""


def warm_up(scenario: ScenarioName = SCENARIO, tracker: Tracker = None, quiet: Quiet = False) -> None:
    """Compile the numba kernels into their cache, so that parallel runs do not each compile them; writes no run."""
    import os
    import time

    # Before numba is imported: it colours an error for each type of argument that it tries, 7 % of the time.
    os.environ.setdefault("NUMBA_DISABLE_ERROR_MESSAGE_HIGHLIGHTING", "1")

    from luxloop.scenarios.files import shipped
    from luxloop.scenarios.files.scenario import Scenario
    from luxloop.scenarios.run import device, loop
    from luxloop.scenarios.run.progress import hidden
    from luxloop.scenarios.run.tracker_warm_up import tracker_beside
    from luxloop.sensor_model.rig.rig import load_rig

    loaded = Scenario.load(shipped.find(scenario), {"duration_s": SIMULATED_S})
    make_device, began = device.load(tracker or device.SHIPPED), time.monotonic()
    with hidden(quiet):
        if tracker is None:
            with tracker_beside(loaded.tracker, load_rig(str(loaded.rig), loaded.folder)):
                loop.run(loaded, device.NoTracks)
        loop.run(loaded, make_device)
    if not quiet:
        print_text(f"The kernels are ready, after {time.monotonic() - began:.1f} s")


def schema(
    study: Annotated[bool, typer.Option("--study", help="Print the schema of study files instead.")] = False,
) -> None:
    """Print the JSON schema of scenario files, for completion in editors."""
    from luxloop.scenarios.files.scenario import Scenario, schema_text
    from luxloop.scenarios.study.study_file import Study

    print_text(schema_text(Study if study else Scenario), end="")
