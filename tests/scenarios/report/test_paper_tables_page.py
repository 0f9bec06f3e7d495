"""docs/paper.md: verdict and tables are those that its script writes."""

import re

from support import short_run
from support.paths import DOCS
from support.scripts import load_script

PAGE = DOCS / "paper.md"
script = load_script(DOCS / "paper_tables.py")
MARKS = ["verdict", *(f"table {number}" for number in range(1, 5))]


def parts(text):
    return dict(re.findall(r"<!-- ([\w ]+) -->\n(.*?)\n<!-- end -->", text, re.DOTALL))


def test_the_script_writes_every_part_of_the_page(tmp_path):
    page = tmp_path / "paper.md"
    page.write_text("".join(f"<!-- {mark} -->\nearlier\n<!-- end -->\n" for mark in MARKS))
    metrics = short_run.result().metrics
    script.write(dict.fromkeys(script.COLUMNS, metrics), page)
    written, shown = parts(page.read_text(encoding="utf-8")), parts(PAGE.read_text(encoding="utf-8"))
    assert written.keys() == set(MARKS) <= shown.keys()
    assert f"| mean abs. e, best | 1.352 | {metrics['fit.heading_abs_mean_deg'].value:.3f} |" in written["table 2"]
    for mark in MARKS[1:]:
        names = [[row.split(" | ")[:2] for row in of[mark].splitlines()] for of in (written, shown)]
        assert names[0] == names[1], mark  # labels and the paper's figures


def test_the_page_begins_with_the_result():
    text = PAGE.read_text(encoding="utf-8")
    first = text.splitlines()[:5]
    assert "not reproduced" in first[0]
    assert any("pictures/paper_gap.png" in line for line in first)
    assert parts(text)["verdict"].startswith("Not reproduced: with the paper's steps, best selection errs by")
