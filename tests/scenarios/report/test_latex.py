"""Tables as LaTeX: every row has its columns, and texts are typeset as written."""

import re

from support import short_run

from luxloop.scenarios.report.html.page_tables import Cell, PageTable, Row
from luxloop.scenarios.report.html.run_page import tables_of
from luxloop.scenarios.report.latex import document, escape, latex


def test_table_by_hand():
    head = [Cell("method", False), Cell("mean |e| [deg]", True)]
    rows = [Row([Cell("best_fit", False), Cell("60 %", True)], "bold"), Row([Cell("[a]", False), Cell("", True)], "")]
    assert latex(PageTable("A & B", head, rows)).splitlines() == [
        r"\begin{table}",
        r"\caption{A \& B}",
        r"\begin{tabular}{lr}",
        r"\toprule",
        r"method & mean $|$e$|$ {[}deg{]} \\",
        r"\midrule",
        r"\textbf{best\_fit} & \textbf{60 \%} \\",
        r"{[}a{]} &  \\",
        r"\bottomrule",
        r"\end{tabular}",
        r"\end{table}",
    ]


def test_special_characters():
    assert escape("a_b\\c{d}~^#$<>") == (
        r"a\_b\textbackslash{}c\{d\}\textasciitilde{}\textasciicircum{}\#\$$<$$>$"
    )  # fmt: skip
    assert escape("two\nlines") == "two lines"


def test_all_tables_of_a_run_have_the_same_number_of_columns_in_every_row():
    tables = tables_of(short_run.result())
    text = document(tables, "a run\nof two lines")
    assert text.startswith("% a run of two lines\n")
    assert text.count(r"\begin{table}") == text.count(r"\end{table}") == len(tables) > 15
    for columns, body in re.findall(r"\\begin\{tabular\}\{([lr]+)\}(.*?)\\end\{tabular\}", text, re.DOTALL):
        rows = [line for line in body.splitlines() if line.endswith(r"\\")]
        assert {len(re.findall(r"(?<!\\)&", row)) for row in rows} == {len(columns) - 1}
