"""Result of a run in a notebook."""

from luxloop.scenarios.document import html
from luxloop.scenarios.document.document import Document, Section
from luxloop.scenarios.files.expect import ranked
from luxloop.scenarios.report.cells import interval_of, table_of, with_unit
from luxloop.scenarios.report.html.reported_run import SUITE_METRICS, answer
from luxloop.scenarios.report.run_document import expectations
from luxloop.scenarios.result import Result


def result_html(result: Result) -> str:
    """Return the verdict, the expectations that do not hold, and the main metrics as HTML."""
    unmet = [check for check in ranked(result.checks) if not check.holds]
    named = {check.name for check in unmet}
    main = table_of("Main metrics", "metric", "value", "95 %")
    for name in SUITE_METRICS:
        if name in result.metrics and name not in named:
            main.add_row(name, with_unit(result.metrics[name]), interval_of(result.metrics[name]))
    title = f"{result.scenario}, seed {result.seed}, {result.frames} frames"
    tables = [*([expectations(unmet)] if unmet else []), main]
    return html.fragment(Document(title, answer(result, result.checks), [], [Section("metrics", "Metrics", tables)]))
