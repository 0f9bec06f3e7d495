"""Tables as LaTeX: every row has its columns, and texts are typeset as written."""

import re

from support import short_run

from luxloop.scenarios.document.document import Table
from luxloop.scenarios.document.latex import escape, latex, latex_table
from luxloop.scenarios.report.text import report


def test_table_by_hand():
    table = Table("A & B")
    table.add_column("method")
    table.add_column("mean |e| [deg]", justify="right")
    table.add_row("best_fit", "60 %", style="bold")
    table.add_row("[a]")
    assert latex_table(table).splitlines() == [
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
    tables = report(short_run.result(), []).tables
    text = latex(tables, "a run\nof two lines")
    assert text.startswith("% a run of two lines\n")
    assert text.count(r"\begin{table}") == text.count(r"\end{table}") == len(tables) > 15
    for columns, body in re.findall(r"\\begin\{tabular\}\{([lr]+)\}(.*?)\\end\{tabular\}", text, re.DOTALL):
        rows = [line for line in body.splitlines() if line.endswith(r"\\")]
        assert {len(re.findall(r"(?<!\\)&", row)) for row in rows} == {len(columns) - 1}
