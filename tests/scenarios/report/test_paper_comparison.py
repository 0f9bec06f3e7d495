"""The paper's tables beside those of runs, and the verdict on them."""

import pytest
from support import short_run

from luxloop.scenarios.document import terminal
from luxloop.scenarios.document.document import plain
from luxloop.scenarios.report import paper_comparison
from luxloop.scenarios.report.paper_comparison import TABLES, verdict
from luxloop.scenarios.result import Metric

NAME = "fit.heading_abs_mean_deg"


def changed(values):
    return short_run.result().metrics | values


def rows(table):
    """Return the cells of each row after the first, by the first."""
    cells = ([plain(cell) for cell in row.cells] for row in table.rows)
    return {first: others for first, *others in cells}


def test_every_source_has_a_column_beside_the_papers():
    one, other = changed({NAME: Metric(1.125, "deg", 77, interval=(0.875, 1.5))}), short_run.result().metrics
    shown = paper_comparison.headings({"one": one, "other": other})
    assert [column.head for column in shown.columns] == ["figure, method", "paper", "one", "other"]
    assert rows(shown)["mean |e|, best"] == ["1.352", "1.125 [0.875, 1.500]", f"{other[NAME].value:.3f}"]
    assert rows(shown)["STD of e, best"][0] == "n/a"  # printed as a negative number
    assert rows(shown)["STD of |e|, variance"][0] == "1.616"


def test_tables_have_the_papers_titles_and_figures():
    tables = [make({"run": short_run.result().metrics}) for make in TABLES]
    titles = [table.title.split(":")[0] for table in tables]
    assert titles == ["Table I", "Table II", "Table III", "Table IV"]
    data_set, _, distribution, positions = map(rows, tables)
    assert data_set["vehicles"] == ["60", "2"]
    assert (data_set["view: rear"][0], data_set["view: front"][0]) == ("3.8%", "")
    assert distribution["best, = 0"][0] == "23.4%"
    assert distribution["best, 5 deg"][0] == "99.3%"
    assert positions["moving, mma, x mean"][0] == "0.238"
    assert positions["moving, single: cv, x mean"][0] == positions["moving, single: ca, x mean"][0] == "0.245"
    assert max(len(line.plain) for line in terminal.lines(tables[3], 1000)) <= 100


def papers_results():
    """Return metrics that equal the paper's."""
    of_methods = {f"{NAME}{{method={name}}}": mean for name, (mean, _) in paper_comparison.HEADING_ABS_DEG.items()}
    of_positions = {
        f"mma.{axis}_abs_mean_m{{target={target}}}": paper_comparison.POSITION_ABS_M["MMA", target][2 * (axis == "y")]
        for axis in "xy"
        for target in ("standing", "moving")
    }
    values = {**of_methods, NAME: paper_comparison.HEADING_ABS_DEG["best"][0], **of_positions}
    return {name: Metric(value, "deg", 9) for name, value in values.items()}


def test_equal_figures_are_reproduced():
    said = verdict("a tracker", changed(papers_results()))
    assert said.startswith(
        "Reproduced: with a tracker, best selection errs by 1.35 degrees (paper 1.35), 5 of 5 methods"
    )


@pytest.mark.parametrize(
    ("other", "said"),
    [
        ({NAME: 3.02}, "errs by 3.02 degrees (paper 1.35), 4 of 5 methods and 4 of 4 positions"),
        ({"mma.x_abs_mean_m{target=moving}": 0.05}, "5 of 5 methods and 3 of 4 positions"),
        (
            {NAME: 1.5},
            "the methods are variance, best, tlinkage, closeness, area (paper: best, variance, tlinkage",
        ),
    ],
)
def test_one_deviation_is_not_reproduced(other, said):
    values = {**papers_results(), **{name: Metric(value, "deg", 9) for name, value in other.items()}}
    sentence = verdict("a tracker", changed(values))
    assert sentence.startswith("Not reproduced: ")
    assert said in sentence


def test_figures_of_the_paper_are_consistent():
    """Tables I to IV: table I adds up, and section V repeats some figures."""
    assert sum(paper_comparison.PAPER_VIEWS.values()) == paper_comparison.DATASET["observations"] == 5353
    assert round(5353 / paper_comparison.DATASET["vehicles"]) == paper_comparison.DATASET["observations_per_vehicle"]
    assert round(5353 / paper_comparison.DATASET["frames"]) == paper_comparison.DATASET["observations_per_frame"]
    assert paper_comparison.HEADING_ABS_DEG["best"][1] == 1.2147
    assert paper_comparison.WITHIN["best"][4] == 0.993
    assert [round(value, 3) for value in paper_comparison.POSITION_ABS_M["MMA", "moving"][::2]] == [0.238, 0.163]
