"""Tables as LaTeX, for the package booktabs."""

from collections.abc import Iterable

from luxloop.scenarios.document.document import Cell, Span, Style, Table, plain

ESCAPED = {
    "\\": r"\textbackslash{}", "&": r"\&", "%": r"\%", "$": r"\$", "#": r"\#", "_": r"\_", "{": r"\{", "}": r"\}",
    "~": r"\textasciitilde{}", "^": r"\textasciicircum{}", "<": r"$<$", ">": r"$>$", "|": r"$|$",
    "[": "{[}", "]": "{]}",
}  # fmt: skip
"""Characters with a meaning in LaTeX, those that its default fonts do not have, and brackets, which after the end of a
row would be taken for an argument."""


def latex(tables: Iterable[Table], about: str) -> str:
    """Return the tables, each as an environment `table`, after a comment on the run."""
    parts = [f"% {' '.join(about.split())}", "% \\usepackage{booktabs}", *map(latex_table, tables)]
    return "\n\n".join(parts) + "\n"


def latex_table(table: Table) -> str:
    """Return a table as an environment `table`; bold rows stay bold."""
    lines = [
        r"\begin{table}",
        rf"\caption{{{escape(table.title)}}}",
        rf"\begin{{tabular}}{{{''.join('r' if column.right else 'l' for column in table.columns)}}}",
        r"\toprule",
        _row([(Span(column.head),) for column in table.columns], ""),
        r"\midrule",
        *(_row(row.cells, row.style) for row in table.rows),
        r"\bottomrule",
        r"\end{tabular}",
        r"\end{table}",
    ]
    return "\n".join(lines)


def escape(text: str) -> str:
    """Return a text that LaTeX typesets as it is written, on one line."""
    return "".join(ESCAPED.get(letter, letter) for letter in " ".join(text.split()))


def _row(cells: Iterable[Cell], style: Style) -> str:
    texts = (escape(plain(cell)) for cell in cells)
    return " & ".join(rf"\textbf{{{text}}}" if text and style == "bold" else text for text in texts) + r" \\"
