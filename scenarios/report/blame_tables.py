"""What a person reads of `luxloop blame`: two tables, of the stages and of the tracks, and a line on every metric."""

from collections.abc import Sequence

from rich.console import Group, RenderableType
from rich.padding import Padding
from rich.table import Table
from rich.text import Text

from scenarios.oracle.stage import Stage
from scenarios.oracle.stage_blame import BLAME_METRICS, OF_STAGES, OF_TRACKS, SHOWN_DIGITS, Blame, BlameMetric
from scenarios.report import text
from scenarios.report.cells import NONE, table_of, value_of

OWN_DRIVES = "The tracks drive the ego: every row is of a drive of its own, with scans of its own."


def tell(blame: Blame) -> RenderableType:
    """Everything there is to say, the verdict last."""
    sections: list[RenderableType] = [
        text.header(blame.shipped),
        _table("Stages, with the truth in the place of one of them", blame, OF_STAGES),
        _table("Tracks, with the truth in the place of one stage", blame, OF_TRACKS),
        _verdicts(blame),
        *([Text(OWN_DRIVES, style="dim")] if blame.shipped.config["control"] else []),
    ]
    return Group(*(Padding(section, (0, 0, 1, 0), expand=False) for section in sections))


def _table(title: str, blame: Blame, headlines: Sequence[BlameMetric]) -> Table:
    """A row for each stage: the metric's value, and its difference below."""
    table = table_of(title, "truth for")
    for headline in headlines:
        table.add_column(headline.title.replace(" ", "\n"), justify="right")
    shipped = blame.shipped.metrics
    table.add_row("none", *(value_of(shipped[headline.name]) for headline in headlines), end_section=True)
    for stage in Stage:
        table.add_row(stage, *(_cell(blame, stage, headline) for headline in headlines))
    return table


def _cell(blame: Blame, stage: Stage, headline: BlameMetric) -> Text:
    metric, gain = blame.by_truth[stage][headline.name], blame.gain(stage, headline)
    if not gain:
        return Text(value_of(metric), style="dim")
    change = gain if headline.better == "more" else -gain
    signed = f"{change:+.0f}" if metric.unit == "count" else f"{change:+.{SHOWN_DIGITS}f}"
    return Text.assemble(value_of(metric), ("\n" + signed, "green" if gain > 0 else "red"))


def _verdicts(blame: Blame) -> Text:
    """A sentence on each metric."""
    lines = [Text("Which stage costs most", style="bold")]
    return Text("\n").join(lines + [Text(_verdict(blame, headline)) for headline in BLAME_METRICS])


def _verdict(blame: Blame, headline: BlameMetric) -> str:
    """Which stage costs most, and which comes next."""
    as_is = blame.shipped.metrics[headline.name]
    if as_is.value is None:
        return f"{headline.name} is {NONE}: {as_is.reason}"
    costly = [f"{stage} ({value_of(blame.by_truth[stage][headline.name])})" for stage in blame.ranking(headline)[:2]]
    verdict = f"{costly[0]} costs most" if costly else "no stage's truth makes it better"
    return f"{headline.name} is {value_of(as_is)}: {', then '.join([verdict, *costly[1:]])}"
