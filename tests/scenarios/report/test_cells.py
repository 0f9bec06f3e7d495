"""Tables of printed reports: nothing is cut off, however narrow the line, and texts are printed as written."""

import io

import pytest

from luxloop.scenarios.document import terminal
from luxloop.scenarios.document.document import Answer, Document, Paragraph, Section
from luxloop.scenarios.report import text
from luxloop.scenarios.report.cells import table_of

NAME = "mma.x_abs_mean_m{target=standing}"


def printed(table, width):
    return "".join(f"{line.plain}\n" for line in terminal.lines(table, width))


def table():
    found = table_of("Metrics", "metric", "BASE", "95 % interval")
    found.add_column("")
    found.add_row(NAME, "0.0713", "-0.0527, +0.0053", "the mean of a long sentence about it")
    return found


@pytest.mark.parametrize("width", [30, 40, 60, 80])
def test_narrow_table_folds_its_cells_and_loses_no_letter(width):
    shown = printed(table(), width)
    assert "…" not in shown
    assert max(map(len, shown.splitlines())) <= width
    expected = (
        "metric" + NAME + "BASE0.0713" + "95%interval-0.0527,+0.0053" + "themeanofalongsentenceaboutit"
    ) + "Metrics"
    assert sorted("".join(shown.replace("─", "").split())) == sorted(expected)


def test_wide_enough_table_keeps_names_and_numbers_on_one_line():
    lines = printed(table(), 90).splitlines()
    assert any(line.startswith(f"{NAME}   0.0713   -0.0527, +0.0053   the mean") for line in lines)


def test_log_is_as_wide_as_its_widest_table():
    name = "a" * 120
    found = table_of("Runs", "run", "n")
    found.add_row(name, "12345")
    words = Paragraph("word " * 40)
    lines = text.as_text(Document("", Answer(""), [words], [Section("runs", "", [found])])).splitlines()
    assert f"{name}   12345" in lines
    assert max(map(len, lines)) == 120 + 3 + 5
    assert max(map(len, text.as_text(Document("", Answer(""), [words], [])).splitlines())) <= text.WIDTH


def test_brackets_and_colons_in_cells_are_printed_as_written(capsys):
    need = "limits are in [/docs/x.md], [bold]not here[/bold] :smile:"
    found = table_of("Expectations", "metric", "value")
    found.add_row(need, "[1]")
    text.show(found)
    assert f"{need}     [1]" in capsys.readouterr().out
    assert f"{need}     [1]" in text.as_text(found)


@pytest.mark.parametrize("width", [4, 7, 11])
def test_lines_are_broken_at_breaks_between_words_and_in_long_ones_and_count_columns(width):
    lines = [line.plain for line in terminal.wrapped(terminal.Line.of("one two\n\nthree 車車車車車車 é"), width)]
    assert all(sum(2 if letter == "車" else 1 for letter in line) <= width for line in lines)
    assert "".join("".join(lines).split()) == "onetwothree車車車車車車é"
    assert "" in lines
    assert all(line == line.strip() for line in lines)


def test_styles_stay_at_their_letters_when_a_line_is_broken():
    one, two = terminal.wrapped(terminal.Line.of(("red words", "31"), " and plain"), 13)
    assert [one.coloured, two.coloured] == ["\x1b[31mred words\x1b[0m and", "plain"]


def test_only_a_terminal_that_wants_colours_gets_them(capsys, monkeypatch):
    monkeypatch.setenv("TERM", "xterm")
    shown = Document("", Answer("said", "failed", "bad"), [], [])
    text.show(shown)
    monkeypatch.setenv("FORCE_COLOR", "1")
    text.show(shown)
    monkeypatch.setenv("NO_COLOR", "1")
    text.show(shown)
    assert capsys.readouterr().out == "FAILED: said\n\n\x1b[1;31mFAILED\x1b[0m: said\n\nFAILED: said\n\n"


def test_a_log_in_an_encoding_without_lines_has_other_signs(monkeypatch):
    out = io.TextIOWrapper(io.BytesIO(), encoding="latin-1")
    monkeypatch.setattr("sys.stdout", out)
    text.show(table())
    out.flush()
    assert b"\n????" in out.buffer.getvalue()
