"""`luxloop blame`."""

import typer

from luxloop.scenarios.commands.arguments import AsJson, Duration, ScenarioName, Seed, overrides
from luxloop.scenarios.commands.error_line import print_early_end


def blame(scenario: ScenarioName, seed: Seed = None, duration: Duration = None, as_json: AsJson = False) -> None:
    """Measure the error that each stage of the shipped tracker causes, by replacing it with the ground truth."""
    import json

    from luxloop.scenarios.compare.stage_costs import stage_costs
    from luxloop.scenarios.files import shipped
    from luxloop.scenarios.files.scenario import Scenario
    from luxloop.scenarios.oracle.stage_blame import document, find_out
    from luxloop.scenarios.report import text
    from luxloop.scenarios.report.blame_tables import blame_report

    found = find_out(Scenario.load(shipped.find(scenario), overrides(seed, duration)))
    costs = stage_costs(found)
    if as_json:
        print(json.dumps(document(found, costs), allow_nan=False))
    else:
        text.show(blame_report(found, costs))
    code, result = 0, found.shipped
    if not result.complete:
        code = print_early_end(result, f"the figures are of the {result.frames} frames until then")
    raise typer.Exit(code)
