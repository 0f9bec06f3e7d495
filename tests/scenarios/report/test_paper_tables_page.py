"""docs/paper.md: its tables have the rows of today's."""

import pytest
from blocks import paper
from support import short_run
from support.pages import block
from support.paths import DOCS

PAGE = DOCS / "paper.md"


@pytest.mark.parametrize("number", [1, 2, 3, 4])
def test_the_tables_have_the_labels_and_the_figures_of_the_paper(number):
    metrics = short_run.result().metrics
    made, shown = paper.as_markdown(number, dict.fromkeys(paper.COLUMNS, metrics)), block(PAGE, f"table {number}")
    assert [row.split(" | ")[:2] for row in made.splitlines()] == [row.split(" | ")[:2] for row in shown.splitlines()]
    if number == 2:
        assert f"| mean abs. e, best | 1.352 | {metrics['fit.heading_abs_mean_deg'].value:.3f} |" in made


def test_the_page_begins_with_the_result():
    first = PAGE.read_text(encoding="utf-8").splitlines()[:8]
    assert "not reproduced" in first[0]
    assert block(PAGE, "verdict").startswith("Not reproduced: with the paper's steps, best selection errs by")
