"""`luxloop compare --report`: the page in a real browser, and Markdown for a pull request."""

import re
from dataclasses import replace
from pathlib import Path

import pytest
from support import browser
from support.paths import ROOT

from luxloop.scenarios.cli import main
from luxloop.scenarios.compare import baseline_file
from luxloop.scenarios.compare.comparison import compare
from luxloop.scenarios.compare.comparison_document import INTERVALS, comparison_document, number
from luxloop.scenarios.compare.digest import Expectation
from luxloop.scenarios.compare.run_pairs import Side, pair
from luxloop.scenarios.compare.vehicle_sums import SUMS
from luxloop.scenarios.document import html, markdown

CATALOG = ROOT / "scenarios" / "baseline" / "catalog.jsonl"
HOSTILE = "a|b`c_<script>alert(1)</script>"
COMMENT_LIMIT = 65536
"""Longest comment of a pull request on GitHub [characters]."""


def scaled(run, factors):
    sums = run.vehicles.sums.copy()
    for column, factor in factors.items():
        sums[:, SUMS.index(column)] *= factor
    return replace(run, trace_hash="changed", vehicles=replace(run.vehicles, sums=sums))


@pytest.fixture(scope="module")
def sides():
    """The catalog, and one with larger heading and smaller position errors of fits, a failure, and an early end."""
    base = [
        run if run.key.scenario != "ring" else replace(run, scenario=HOSTILE, seed=1)
        for run in baseline_file.read(CATALOG)
    ]
    base[0] = replace(base[0], expectations={"track.hota": Expectation("passed", 0.9, ">= 0.75")})
    head = [scaled(run, {"fit_heading_deg": 1.05, "fit_position_m": 0.9}) for run in base]
    head[0] = replace(head[0], expectations={"track.hota": Expectation("failed", 0.1, ">= 0.75")})
    head[1] = replace(head[1], ended_early="the ego [arrived]")
    return base, head


@pytest.fixture(scope="module")
def compared(sides):
    base, head = (Side(Path("x"), {run.key: run for run in runs}, []) for runs in sides)
    return compare(pair(base, head))


@pytest.fixture(scope="module")
def page(compared, tmp_path_factory):
    path = tmp_path_factory.mktemp("page") / "comparison.html"
    path.write_text(html.page(comparison_document(compared, "base.jsonl", "runs <head>")), encoding="utf-8")
    return path


@pytest.fixture(scope="module")
def chromium():
    with browser.started() as found:
        yield found


@pytest.mark.slow
def test_page_at_1280_pixels_shows_everything_without_scrolling(chromium, page):
    with browser.opened(chromium, page, viewport={"width": 1280, "height": 900}) as shown:
        assert browser.cut_off(shown) == []
        assert shown.evaluate("document.documentElement.scrollWidth") == 1280
        assert shown.locator("h1 .badge").inner_text() == "worse"
        assert shown.locator("header").inner_text().count("1 expectation newly fails, 1 run newly ends early") == 1
        headings = shown.locator("#summary h3").all_inner_texts()
        assert headings == ["Newly incomplete", "Newly failed", "Worse", "Better"]
        assert shown.locator("script").count() == 0
        assert HOSTILE in shown.locator("#pairs").inner_text()
        assert INTERVALS in shown.locator("#metrics").inner_text()
        assert shown.recorded == []


@pytest.mark.slow
def test_page_on_a_phone_is_as_wide_as_the_phone(chromium, page):
    with browser.opened(chromium, page, viewport={"width": 390, "height": 844}) as shown:
        assert shown.evaluate("document.documentElement.scrollWidth") <= 390


def test_page_has_the_numbers_of_the_comparison(compared, page):
    text = page.read_text(encoding="utf-8")
    fit = next(change for change in compared.changes if change.metric.name == "fit.heading_abs_mean_deg")
    assert fit.numbers.head == pytest.approx(1.05 * fit.numbers.base)
    cells = (number(fit.numbers.base), number(fit.numbers.head), number(fit.numbers.difference, "+"))
    row = "".join(f'<td class="right">{re.escape(cell)}</td>' for cell in cells)
    assert re.search(f"fit.<wbr>heading_<wbr>abs_<wbr>mean_<wbr>deg</code></th>{row}", text)
    assert "luxloop compare base.jsonl &#39;runs &lt;head&gt;&#39; --loss 2" in text


def test_markdown_has_the_verdict_first_then_losses_then_gains_and_folded_tables(compared):
    text = markdown.markdown(comparison_document(compared, "base.jsonl", "runs"))
    order = ["### Comparison of two versions: worse", "**HEAD fits headings worse", "**Newly incomplete**",
             "**Newly failed**", "**Worse**", "- `fit.heading_abs_mean_deg`:", "**Better**",
             "- `fit.position_abs_mean_m`:", "<details><summary>Metrics</summary>",
             INTERVALS.split(":")[0].replace("_", "\\_")]  # fmt: skip
    assert [text.index(part) for part in order] == sorted(text.index(part) for part in order)
    assert text.count("<details>") == text.count("</details>") >= 3
    assert len(text) < COMMENT_LIMIT / 4


@pytest.mark.slow
def test_every_row_of_a_markdown_table_has_as_many_cells_as_its_head(sides):
    base, _ = sides
    failing = {"track.hota": Expectation("failed", 0.1, ">= 0.75")}
    head = [replace(scaled(run, {"fit_heading_deg": 1.05}), expectations=failing) for run in base]
    both = (Side(Path("x"), {run.key: run for run in runs}, []) for runs in (base, head))
    text = markdown.markdown(comparison_document(compare(pair(*both)), "a", "b"))
    tables = re.findall(r"(?:^\|.*\|\n)+", text, re.MULTILINE)
    assert len(tables) >= 2
    for table in tables:
        cells = {len(re.findall(r"(?<!\\)\|", line)) for line in table.splitlines()}
        assert len(cells) == 1, table
    assert "more in the tables below" in text  # of 49 failures, eight are listed
    assert "<script>" not in re.sub(r"(?<!`)(`+)(?!`).*?(?<!`)\1(?!`)", "", text)  # outside of code spans
    assert len(text) < COMMENT_LIMIT / 2


def test_markdown_keeps_hostile_names_as_text():
    assert markdown.code("a`b|c") == "`` a`b\\|c ``"
    assert markdown.code("two\nlines") == "`two lines`"
    assert markdown.plain("a_b <= [c](d) @e") == "a\\_b \\<= \\[c\\](d) \\@e"


@pytest.fixture
def files(sides, tmp_path):
    """Baseline files of eight runs of both sides: what is compared is of no interest where they are used."""
    for name, runs in zip(("base", "head"), sides, strict=True):
        baseline_file.write(tmp_path / f"{name}.jsonl", runs[:8])
    return str(tmp_path / "base.jsonl"), str(tmp_path / "head.jsonl")


@pytest.mark.parametrize(
    ("name", "written"),
    [("a.html", ["a.html"]), ("a.md", ["a.md"]), ("both", ["both/comparison.html", "both/comparison.md"])],
)
def test_the_name_decides_about_the_format(files, tmp_path, capsys, name, written):
    code = main(["compare", *files, "--report", str(tmp_path / "out" / name)])
    assert code == 1
    found = sorted(path.relative_to(tmp_path / "out").as_posix() for path in (tmp_path / "out").rglob("*.*"))
    assert found == written
    assert f"The comparison is in {tmp_path / 'out' / written[0]}" in capsys.readouterr().out


def test_report_with_another_ending_is_refused_before_anything_is_written(files, tmp_path, capsys):
    assert main(["compare", *files, "--report", str(tmp_path / "a.pdf")]) == 2
    out, err = capsys.readouterr()
    assert (out, err.count("\n")) == ("", 1)
    assert "a.pdf: give a name that ends in .html or .md, or a folder for both" in err
    assert main(["compare", *files, "--report", str(Path(files[0]) / "a.md")]) == 2
    assert "choose another path with --report" in capsys.readouterr().err
    assert sorted(path.name for path in tmp_path.iterdir()) == ["base.jsonl", "head.jsonl"]


def test_json_stays_alone_on_standard_output(files, tmp_path, capsys):
    main(["compare", *files, "--json", "--report", str(tmp_path / "a.md")])
    assert capsys.readouterr().out.count("\n") == 1
    assert (tmp_path / "a.md").read_text(encoding="utf-8").startswith("### Comparison of two versions: worse")
