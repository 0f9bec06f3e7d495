"""Commands that compare runs: `luxloop compare`, `baseline`, `trends`, `ceiling` and `blame`."""

from pathlib import Path
from typing import Annotated

import typer

from luxloop.printable import print_text
from luxloop.scenarios.commands.arguments import AsJson, Duration, Quiet, ScenarioName, Seed, Tracker, finite, overrides
from luxloop.scenarios.commands.error_messages import print_early_end
from luxloop.scenarios.errors import InputError
from luxloop.scenarios.exit_codes import ExitCode

BASE_OR_HEAD = "A folder of runs, a single run, or a file that `luxloop baseline` wrote"


def compare(
    base: Annotated[Path, typer.Argument(metavar="BASE", help=f"{BASE_OR_HEAD}: the reference.")],
    head: Annotated[Path, typer.Argument(metavar="HEAD", help="The same: the runs to judge.")],
    loss: Annotated[
        float,
        typer.Option(
            metavar="PERCENT", min=0.0, max=100.0, callback=finite, help="Loss to exclude for an exit code of 0 [%]."
        ),
    ] = 2.0,
    report: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="Also write a page (.html), Markdown (.md), or both into a folder."),
    ] = None,
    as_json: AsJson = False,
    quiet: Quiet = False,
) -> None:
    """Compare runs of the same scenarios and seeds.

    Exit code: 0 if HEAD is the same or better, 1 if it is worse or newly fails, 5 if the runs cannot tell.
    """
    from luxloop.scenarios import interface
    from luxloop.scenarios.compare.comparison_document import comparison_document, files_of, write
    from luxloop.scenarios.document.document import json_text
    from luxloop.scenarios.report import text

    files = files_of(report) if report else []
    comparison = interface.compare(base, head, loss=loss / 100.0)
    shown = comparison_document(comparison, str(base), str(head))
    write(files, shown)
    if as_json:
        print_text(json_text(shown))
    elif not quiet:
        text.show(shown)
        if files:
            print_text(f"The comparison is in {' and '.join(map(str, files))}")
    raise typer.Exit({"worse": ExitCode.FAILED, "cannot tell": ExitCode.CANNOT_TELL}.get(comparison.verdict, 0))


def baseline(
    runs: Annotated[Path, typer.Argument(metavar="RUNS", help="The folder of runs that become the baseline.")],
    out: Annotated[Path, typer.Option(help="The file to write and commit; it replaces an earlier baseline.")],
) -> None:
    """Write a baseline file for `luxloop compare`. No other command changes one."""
    from luxloop.scenarios.compare import baseline_file as file
    from luxloop.scenarios.compare import run_pairs
    from luxloop.scenarios.compare.run_pairs import listed

    side = run_pairs.read_runs(runs)
    before = {run.key: run for run in file.read(out)} if out.exists() else {}
    file.write(out, list(side.runs.values()))
    changed = [key for key in side.runs if key in before and side.runs[key].trace_hash != before[key].trace_hash]
    print_text(f"{out}: {len(side.runs)} runs, {out.stat().st_size / 1000:.0f} kB")
    for what, keys in (
        ("new", [key for key in side.runs if key not in before]),
        ("changed", changed),
        ("dropped", [key for key in before if key not in side.runs]),
        ("ended early, and are not compared", [key for key, run in side.runs.items() if run.ended_early]),
    ):
        if keys:
            print_text(f"{len(keys)} {what}: {listed(keys)}")


def trends(
    baselines: Annotated[
        list[Path],
        typer.Argument(metavar="BASELINE...", help="Files of `luxloop baseline`, or folders of runs; earliest first."),
    ],
    out: Annotated[Path, typer.Option(metavar="FILE", help="The page to write.")] = Path("trends.html"),
) -> None:
    """Draw the key metrics over many baselines, of all runs together and of each scenario, on one page."""
    from luxloop.scenarios.compare import run_pairs
    from luxloop.scenarios.compare.trends import trends as trends_of
    from luxloop.scenarios.compare.trends import trends_document
    from luxloop.scenarios.document import html
    from luxloop.scenarios.report import text

    shown = trends_document(trends_of([run_pairs.read_side(path) for path in baselines]))
    html.write(out, shown)
    text.show(shown)
    print_text(f"The page is {out}")


def ceiling(
    scenario: ScenarioName,
    seed: Seed = None,
    seeds: Annotated[
        str | None, typer.Option(metavar="FIRST-LAST", help="Run all these seeds, e.g. 1-6, and print means.")
    ] = None,
    duration: Duration = None,
    heading_std: Annotated[
        float, typer.Option(metavar="DEG", min=0.0, callback=finite, help="Heading error of the noisy ceiling [deg].")
    ] = 1.0,
    position_std: Annotated[
        float, typer.Option(metavar="M", min=0.0, callback=finite, help="Position error of the noisy ceiling [m].")
    ] = 0.05,
    as_json: AsJson = False,
) -> None:
    """Print HOTA beside that of an ideal causal tracker, which knows all that the scans have shown so far."""
    from luxloop.scenarios import interface
    from luxloop.scenarios.document.document import json_text
    from luxloop.scenarios.files import option_values
    from luxloop.scenarios.oracle.ceiling_tracker import PoseNoise
    from luxloop.scenarios.report import text
    from luxloop.scenarios.report.ceiling_document import ceiling_document

    if seed is not None and seeds is not None:
        raise InputError("--seed and --seeds are both given; omit one")
    chosen = option_values.parse_seeds(seeds) if seeds else [seed] if seed is not None else []
    found = interface.ceiling(
        scenario, seeds=chosen, duration_s=duration, heading_std_deg=heading_std, position_std_m=position_std
    )
    shown = ceiling_document(found, PoseNoise(heading_std, position_std))
    if as_json:
        print_text(json_text(shown))
    else:
        text.show(shown)
    raise typer.Exit(ExitCode.FAILED if any(one.ended_early for one in found) else 0)


def blame(
    scenario: ScenarioName,
    seed: Seed = None,
    duration: Duration = None,
    tracker: Tracker = None,
    as_json: AsJson = False,
) -> None:
    """Measure the error that each stage of a tracker causes, by replacing it with the ground truth."""
    import json

    from luxloop.scenarios.compare.stage_costs import blame_report, stage_costs
    from luxloop.scenarios.files import shipped
    from luxloop.scenarios.files.scenario import Scenario
    from luxloop.scenarios.oracle.stage_blame import document, find_out
    from luxloop.scenarios.report import text
    from luxloop.scenarios.run import device

    make_tracker = device.load(tracker or device.SHIPPED, in_process=True)  # oracles replace its stages
    found = find_out(Scenario.load(shipped.find(scenario), overrides(seed, duration)), make_tracker)
    costs = stage_costs(found)
    if as_json:
        print_text(json.dumps(document(found, costs), allow_nan=False))
    else:
        text.show(blame_report(found, costs))
    code, result = 0, found.shipped
    if not result.complete:
        code = print_early_end(result, f"the figures are of the {result.frames} frames until then")
    raise typer.Exit(code)
