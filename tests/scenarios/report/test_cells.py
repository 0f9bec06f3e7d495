"""Tables of printed reports: nothing is cut off, however narrow the line, and texts are printed as written."""

import io

import pytest
from rich.console import Console, Group
from rich.padding import Padding
from rich.text import Text

from luxloop.scenarios.report import text
from luxloop.scenarios.report.cells import table_of

NAME = "mma.x_abs_mean_m{target=standing}"


def printed(table, width):
    out = io.StringIO()
    Console(file=out, width=width, color_system=None).print(table)
    return out.getvalue()


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
    report = Group(Padding(Text("word " * 40), (0, 0, 1, 0), expand=False), Padding(found, (0, 0, 1, 0), expand=False))
    lines = text.as_text(report).splitlines()
    assert f"{name}   12345" in lines
    assert max(map(len, lines)) == 120 + 3 + 5
    assert max(map(len, text.as_text(Text("word " * 40)).splitlines())) <= text.WIDTH


def test_brackets_and_colons_in_cells_are_printed_as_written(capsys):
    need = "limits are in [/docs/x.md], [bold]not here[/bold] :smile:"
    found = table_of("Expectations", "metric", "value")
    found.add_row(need, "[1]")
    text.show(found)
    assert f"{need}     [1]" in capsys.readouterr().out
    assert f"{need}     [1]" in text.as_text(found)


def test_a_text_that_is_known_is_printed_as_it_is_except_on_a_terminal(capsys, monkeypatch):
    text.show(Text("report"), "report as text\n")
    monkeypatch.setenv("FORCE_COLOR", "1")
    text.show(Text("report"), "report as text\n")
    assert capsys.readouterr().out == "report as text\nreport\n"
