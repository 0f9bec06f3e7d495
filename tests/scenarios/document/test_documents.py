"""A document in every format, by hand."""

import json
import math
import re

import pytest

from luxloop.scenarios.document import html, latex, markdown, terminal
from luxloop.scenarios.document.document import (
    LISTED,
    Answer,
    Bullets,
    Document,
    Facts,
    Folded,
    Legend,
    Paragraph,
    Preformatted,
    Section,
    Span,
    Table,
    code,
    json_text,
)
from luxloop.scenarios.document.figure import Figure

HOSTILE = "<b>|`_&"


def table():
    found = Table("Metrics")
    found.add_column("metric")
    found.add_column("value [m]", justify="right")
    found.add_row(code("track.hota"), "0.5")
    found.add_row(HOSTILE, Span("worse", "bad"), style="bold")
    return found


def figure(name="a"):
    return Figure(
        name, "A figure", "It shows a line", (3.0, 2.0), lambda canvas: canvas.subplots().plot([0, 1], [0, 1])
    )


def document(**changes):
    values = {
        "title": "A page",
        "answer": Answer("HEAD is fine", "better", "good"),
        "lead": [figure(), Facts({"runs": "2"})],
        "sections": [
            Section("one", "First", [Paragraph("A sentence."), table(), Folded("More", [Preformatted("hidden")])]),
            Section("two", "Second", [Bullets([f"item {n}" for n in range(12)], "Items"), Legend([("dot", "a dot")])]),
            Section("far", "Only on a page", [Preformatted("luxloop run ring")], page_only=True),
        ],
        "data": {"n": 1, "nothing": math.nan, "inner": [{"end": math.inf}]},
    }
    return Document(**values | changes)


def printed(shown):
    return [line.plain for line in terminal.lines(shown, 80)]


def test_a_terminal_has_the_answer_first_and_no_pictures_or_folded_parts():
    lines = printed(document())
    assert lines[0] == "BETTER: HEAD is fine"
    assert [line for line in lines if line.startswith("item")] == [f"item {n}" for n in range(12)]
    assert "runs 2" in lines
    assert any(line.split() == ["track.hota", "0.5"] for line in lines)
    assert any(HOSTILE in line for line in lines)
    assert not {"hidden", "luxloop run ring", "A figure"} & set(lines)


def test_a_page_has_everything_with_the_answer_before_the_figure_and_escaped():
    text = html.page(document())
    order = ["better</span></h1>", "<strong>HEAD is fine.</strong>", '<figure id="a"', "<nav", 'id="one"', "item 11",
             "luxloop run ring"]  # fmt: skip
    assert [text.index(part) for part in order] == sorted(text.index(part) for part in order)
    assert "<b>" not in text
    assert "hidden" in text
    assert "<script" not in text
    assert "First</h2>" in text


def test_a_title_that_repeats_its_heading_is_left_out_on_a_page():
    section = Section("one", "Metrics", [table()])
    assert "<caption>" not in html.page(document(sections=[section]))
    assert "Metrics" in printed(document(sections=[section]))


def test_markdown_and_latex_and_json():
    lines = markdown.markdown(document()).splitlines()
    assert lines[:3] == ["### A page: better", "", "**HEAD is fine.**"]
    assert "| `track.hota` | 0.5 |" in lines
    assert "| --- | ---: |" in lines
    assert f"- {12 - LISTED} more in the tables below" in lines
    assert "luxloop run ring" not in lines
    assert latex.latex(document().tables, "about\nit").splitlines()[0] == "% about it"
    data = json.loads(json_text(document(), out="x"))
    assert data == {
        "verdict": "better", "answer": "HEAD is fine", "n": 1, "nothing": None, "inner": [{"end": None}], "out": "x",
    }  # fmt: skip


def test_a_row_has_no_more_cells_than_columns():
    with pytest.raises(ValueError, match="Metrics: 3 cells for 2 columns"):
        table().add_row("a", "b", "c")


def test_a_figure_that_is_drawn_keeps_its_picture_without_its_data():
    one = figure()
    drawn = one.drawn()
    assert drawn.svg == one.svg
    assert drawn.paint is not one.paint
    assert len(re.findall("<path", one.svg)) > 3
