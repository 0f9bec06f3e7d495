"""Write the paper's four tables, beside those of its own steps and of the default tracker, into docs/paper.md.

    luxloop paper
    python docs/paper_tables.py runs/paper-campus-seed1-paper runs/paper-campus-seed1

`luxloop paper` makes the runs. Tables and the sentence of the verdict are between `<!-- table 1 -->` ...
`<!-- table 4 -->` or `<!-- verdict -->` and `<!-- end -->`.
"""

import sys
from pathlib import Path

from fits.league_tables import markdown
from marked_text import replace

from luxloop.scenarios.document.document import plain
from luxloop.scenarios.interface import load_result
from luxloop.scenarios.report.paper_comparison import TABLES, Sources, verdict

PAGE = Path(__file__).parent / "paper.md"
COLUMNS = ("the paper's steps", "default")


def main() -> None:
    """Write the verdict and the tables."""
    runs = [Path(word) for word in sys.argv[1:]]
    if len(runs) != len(COLUMNS):
        sys.exit(f"give two folders of runs: {' and '.join(COLUMNS)}")
    write({name: load_result(run).metrics for name, run in zip(COLUMNS, runs, strict=True)})


def write(sources: Sources, page: Path = PAGE) -> None:
    """Write the verdict on the first source, and the tables of all of them."""
    replace(page, "verdict", verdict(COLUMNS[0], sources[COLUMNS[0]]))
    for number, make in enumerate(TABLES, start=1):
        table = make(sources)
        rows = [[plain(cell).replace("|e|", "abs. e") for cell in row.cells] for row in table.rows]
        replace(page, f"table {number}", markdown([column.head for column in table.columns], rows))


if __name__ == "__main__":
    main()
