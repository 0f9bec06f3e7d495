"""HTML reports: contents, and display in a real browser, on a phone and on paper, without network requests."""

import re
from contextlib import ExitStack
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from markupsafe import escape
from support import browser, short_run, warm_process
from support.few import few

from luxloop.scenarios.cli import main
from luxloop.scenarios.document import html
from luxloop.scenarios.document.document import plain
from luxloop.scenarios.document.figure import Figure
from luxloop.scenarios.document.palette import TONES
from luxloop.scenarios.execute import execute
from luxloop.scenarios.files.scenario import Scenario
from luxloop.scenarios.report import paper_comparison
from luxloop.scenarios.report.html.reported_run import ReportedRun
from luxloop.scenarios.report.html.run_page import (
    COVARIATES,
    errors_against,
    errors_by_class,
    most_mode_changes,
    observations,
    run_page,
)
from luxloop.scenarios.report.html.suite_page import Broken, find_runs, suite_page
from luxloop.scenarios.report.html.timelines import HIDDEN, MISSED, OUT, periods
from luxloop.scenarios.run import device
from luxloop.tracker.records import MODELS
from luxloop.tracker.tracker import Tracker

EXPECT = """
[expect]
"track.mota" = { max = 1.0, unit = "1", need = "scores are at most one" }
"fit.heading_abs_mean_deg" = { max = 0.001, unit = "deg", need = "a ruler's edge" }
"track.idf1" = { min = 0.999, known_failure = "the first frames have <no> track yet" }
"""
FIGURES = ["heading-cdf", "error-range", "error-aspect", "error-visible", "error-class", "timelines", "probabilities"]


def run_into(folder, text, name="short"):
    path = short_run.write(folder, text, name)
    make_device = device.load(device.SHIPPED)
    execute(Scenario.load(path), make_device, folder / "runs" / f"{name}-seed4", record=False)
    return folder / "runs" / f"{name}-seed4"


@pytest.fixture(scope="module")
def runs(tmp_path_factory):
    """A run that fails, with a known failure, and a run that passes."""
    folder = tmp_path_factory.mktemp("suite")
    run_into(folder, short_run.TEXT.replace("[bold]", "<script>alert(1)</script>") + EXPECT, "bad")
    run_into(folder, short_run.TEXT + '[expect]\n"track.hota" = { min = 0.0 }\n', "good")
    return folder / "runs"


@pytest.fixture(scope="module")
def pages(runs):
    page = runs.parent / "run.html"
    page.write_text(html.page(run_page(runs / "bad-seed4")), encoding="utf-8")
    suite = runs.parent / "suite.html"
    broken = [Broken("torn.toml::torn", "torn.toml: not TOML: <line 3>")]
    suite.write_text(html.page(suite_page(find_runs(runs), broken)), encoding="utf-8")
    return {"run": page, "suite": suite}


@pytest.fixture(scope="module")
def chromium():
    with browser.started() as found:
        yield found


@pytest.fixture
def opened(chromium, pages):
    """Open a page by its name, and record its errors and requests."""
    with ExitStack() as stack:
        yield lambda name, **options: stack.enter_context(browser.opened(chromium, pages[name], **options))


PHONE = {"viewport": {"width": 390, "height": 844}}


@pytest.mark.slow
@pytest.mark.parametrize("name", ["run", "suite"])
def test_phone_shows_the_verdict_without_scrolling(opened, name):
    page = opened(name, **PHONE)
    assert page.evaluate("document.documentElement.scrollWidth") <= 390
    verdict = page.locator("h1 .badge").first
    assert verdict.inner_text() == "failed"
    box = verdict.bounding_box()
    assert box["x"] + box["width"] <= 390
    assert box["y"] + box["height"] <= 844
    assert page.recorded == []


@pytest.mark.slow
def test_every_figure_is_drawn_with_alternative_text(opened):
    page = opened("run")
    shown = page.locator("figure").evaluate_all("all => all.map(element => element.id)")
    assert [name for name in shown if not name.startswith("short")][-len(FIGURES) :] == FIGURES
    assert any(name.startswith("bad-frame-") for name in shown)
    for drawing in page.locator("figure svg").all():
        box = drawing.bounding_box()
        assert box["width"] > 200
        assert box["height"] > 80
        assert len(drawing.get_attribute("aria-label")) > 20
        assert drawing.locator("path").count() > 3
    assert page.recorded == []


@pytest.mark.slow
def test_page_has_the_colour_scheme_of_the_browser(opened):
    def color(scheme, of):
        return (
            opened("run", color_scheme=scheme)
            .locator(of)
            .first.evaluate("one => getComputedStyle(one)[one.tagName == 'BODY' ? 'backgroundColor' : 'fill']")
        )

    def rgb(tone):
        return f"rgb({', '.join(str(int(tone[k : k + 2], 16)) for k in (1, 3, 5))})"

    for scheme in ("light", "dark"):
        assert color(scheme, "body") == rgb(getattr(TONES["page"], scheme))
        assert color(scheme, "#timelines svg text") in {rgb(getattr(TONES[name], scheme)) for name in ("ink", "muted")}


@pytest.mark.slow
def test_printed_page_is_complete_without_split_figures(opened):
    """Fails when a figure or table is wider than the sheet, or a page break may split a figure."""
    page = opened("run", viewport={"width": 688, "height": 1000})  # A4 less its margins, at 96 dots per inch
    page.emulate_media(media="print")
    assert page.evaluate("document.documentElement.scrollWidth") <= 688
    wide = "all => all.filter(one => one.getBoundingClientRect().right > innerWidth + 1).map(one => one.outerHTML)"
    assert page.locator("figure, figure svg").evaluate_all(wide) == []
    inside = page.locator("figure").evaluate_all("all => all.map(one => getComputedStyle(one).breakInside)")
    assert set(inside) == {"avoid"}
    assert page.pdf(prefer_css_page_size=True).startswith(b"%PDF")


def test_tones_are_different():
    """Figures refer to tones by their light variants."""
    assert len({tone.light for tone in TONES.values()}) == len(TONES)


@pytest.mark.slow
def test_links_in_a_page_have_targets(opened):
    for name in ("run", "suite"):
        page = opened(name)
        targets = page.locator("a").evaluate_all("all => all.map(one => one.getAttribute('href'))")
        assert any("-frame-" in target for target in targets)  # from a failed expectation to a picture
        assert targets
        assert all(page.locator(f'[id="{target[1:]}"]').count() == 1 for target in targets)
        ids = page.locator("[id]").evaluate_all("all => all.map(one => one.id)")
        assert len(ids) == len(set(ids))


@pytest.mark.slow
def test_text_of_a_run_is_escaped(opened):
    page = opened("run")
    assert "<script>alert(1)</script>" in page.locator("header").inner_text()
    scripts = page.locator("script").evaluate_all("all => all.map(one => one.id || one.textContent.slice(0, 12))")
    assert scripts == ["player-data", '"use strict"']


def test_page_shows_the_verdict_with_needs_and_reasons(pages):
    text = pages["run"].read_text(encoding="utf-8")
    assert "1 of 3 expectations hold, 1 failed, 1 known failure" in text
    assert str(escape("a ruler's edge")) in text
    assert "the first frames have &lt;no&gt; track yet" in text
    assert re.search(r"frame \d+ \(\d\.\d\d s\): .* on vehicle \S+ .*: heading error -?[\d.]+ deg", text)


def test_run_page_has_the_numbers_of_the_printed_tables(runs, pages):
    run, text = ReportedRun.read(runs / "bad-seed4"), pages["run"].read_text(encoding="utf-8")
    best = next(row for row in paper_comparison.heading_error(run.result).rows if plain(row.cells[0]) == "best")
    shown = [plain(cell) for cell in best.cells[1:]]
    assert f"{run.result.metrics['fit.heading_abs_mean_deg'].value:.3f}" in shown
    assert best.style == "bold"
    assert "".join(f'<td class="right">{cell}</td>' for cell in shown) in text


def test_figures_shorten_coordinates_and_not_text():
    def on(canvas):
        canvas.subplots().text(0.123456, 0.5, "0.139 of 2.71828")

    svg = Figure("a", "A figure", "With a text", (3.0, 2.0), on).svg
    assert "0.139 of 2.71828" in svg
    assert not re.search(r'="[^"]*\d\.\d{3}', svg)


def test_run_page_shows_the_commands_that_reproduce_it(runs, pages):
    run = ReportedRun.read(runs / "bad-seed4")
    folder = runs / "bad-seed4"
    assert run.commands == [f"luxloop run bad.toml --seed 4 --out {folder}", f"luxloop view {folder}"]
    oracle = replace(run.result, config={**run.result.config, "device": "oracle: fit, model"})
    assert "--oracle fit --oracle model" in replace(run, result=oracle).commands[0]
    own = replace(run.result, config={**run.result.config, "device": "mine.tracker:Own"})
    assert "--tracker mine.tracker:Own" in replace(run, result=own).commands[0]
    others = replace(run.result, config={**run.result.config, "device": "tracks.csv"})
    assert replace(run, result=others).commands == ["luxloop grade RUN --tracks tracks.csv"]
    assert run.result.trace_hash in pages["run"].read_text(encoding="utf-8")


class Untraced(Tracker):
    def step(self, scan):
        return super().step(scan)[0]


EMPTY = 'description = "No actors."\nduration_s = 0.8\n[traffic]\nkind = "scripted"\n'
SPECIAL_CASES = {
    "tracker without a trace": (short_run.TEXT, Untraced, {}),
    "no actors": (EMPTY, Tracker, {}),
    "a single frame": (short_run.TEXT, Tracker, {"duration_s": 0.08}),
    "baselines": (short_run.TEXT + "[tracker.baselines]\nenabled = true\n", Tracker, {}),
}


@pytest.mark.parametrize("case", few(SPECIAL_CASES, "tracker without a trace"))
def test_page_of_special_cases(tmp_path, case):
    """Fails when a figure or table requires data that a run may lack; warnings are errors here."""
    text, factory, overrides = SPECIAL_CASES[case]
    scenario = Scenario.load(short_run.write(tmp_path, text), overrides)
    execute(scenario, factory, tmp_path / "run", record=False)
    page = html.page(run_page(tmp_path / "run"))
    assert all(f'id="{name}"' in page for name in FIGURES)
    assert ("autoware" in page[: page.index("Effective configuration")]) == (case == "baselines")


def test_suite_page_shows_failures_first_and_is_small(pages, runs):
    text = pages["suite"].read_text(encoding="utf-8")
    order = ["torn.toml::torn", 'id="known"', '<details id="bad-seed4" open', '<details id="good-seed4">']
    assert [text.index(part) for part in order] == sorted(text.index(part) for part in order)
    assert "<strong>1 of 3 runs passed, 1 failed, 1 could not be run; known failures: 1.</strong>" in text
    assert len(text) < 5e6 / 40 * len(find_runs(runs))


def test_report_command_writes_a_page_of_a_run_or_of_many(runs, capfd, tmp_path):
    out = tmp_path / "deep" / "page.html"
    assert main(["report", str(runs / "good-seed4"), "--out", str(out)]) == 0
    assert "<title>good: passed</title>" in out.read_text(encoding="utf-8")
    assert main(["report", str(runs)]) == 0
    assert "<title>failed: 2 runs</title>" in (runs.parent / "runs.html").read_text(encoding="utf-8")
    capfd.readouterr()
    assert main(["report", str(tmp_path / "deep")]) == 2
    assert "no run in it" in capfd.readouterr().err


@pytest.mark.slow
def test_pytest_writes_the_report_of_all_workers(tmp_path):
    (tmp_path / "pytest.ini").write_text("[pytest]\n")
    short_run.write(tmp_path, short_run.TEXT + EXPECT, "bad")
    short_run.write(tmp_path, short_run.TEXT.replace("seed = 4", 'seed = "four"'), "broken")
    command = ["pytest", "-p", "no:cacheprovider", "-n", "1", "--luxloop-report", "all.html"]
    run = warm_process.run(*command, cwd=tmp_path)
    assert "The report is in all.html" in run.stdout, run.stdout + run.stderr
    text = (tmp_path / "all.html").read_text(encoding="utf-8")
    assert "<strong>0 of 2 runs passed, 1 failed, 1 could not be run" in text
    assert "broken.toml::broken" in text
    assert '<details id="bad-seed4" open' in text


def vehicle(**columns):
    count = len(columns["graded"])
    frame = np.arange(count)
    rows = {"frame": frame, "time_s": 0.1 * frame, "hits_alone": 50, "visible_fraction": 1.0, **columns}
    return pd.DataFrame({name: np.broadcast_to(values, count) for name, values in rows.items()})


def test_timelines_show_tracks_occlusions_and_missed_periods():
    rows = vehicle(
        graded=[False, True, True, True, False, False, False, True, True, False],
        track_id=[7, 7, 7, -1, -1, -1, -1, 9, 9, 9],
        visible_fraction=[1, 1, 1, 1, 0.05, 0.05, 0.5, 1, 1, 1],
    )
    found = [(round(p.begin_s, 6), round(p.end_s, 6), p.state) for p in periods(rows, hidden_fraction_max=0.1)]
    # From the first graded row to the last; a row lasts until the next one.
    expected = [(0.1, 0.3, 7), (0.3, 0.4, MISSED), (0.4, 0.6, HIDDEN), (0.6, 0.7, OUT), (0.7, 0.9, 9)]
    assert found == expected


def test_errors_by_aspect_and_visible_fraction():
    """Aspect by hand: a vehicle that drives ahead shows its rear, an oncoming one its front, one abreast its side."""
    fits = pd.DataFrame(
        {
            "frame": [0, 0, 0],
            "actor_id": [1, 2, 3],
            "best": True,
            "heading_error_deg": [1.0, -3.0, 5.0],
            "position_error_m": 0.1,
            "range_m": [10.0, 10.0, 50.0],
            "true_x_ego_m": [10.0, 10.0, 0.0],
            "true_y_ego_m": [0.0, 0.0, 4.0],
            "true_yaw_ego_rad": [0.0, np.pi, 0.0],
        }
    )
    truth = pd.DataFrame({"frame": [0, 0, 0], "actor_id": [3, 2, 1], "visible_fraction": [0.3, 0.2, 1.0]})
    truth["kind"] = pd.Categorical(["bus", "car", "car"], ["car", "bus", "van"])
    observed = observations(fits, truth)
    assert observed["aspect_deg"].tolist() == pytest.approx([180.0, 0.0, 90.0])
    assert observed["visible_fraction"].tolist() == [1.0, 0.2, 0.3]
    counts = {
        covariate.name: re.findall(r"n=(\d+)", errors_against(observed, covariate).svg) for covariate in COVARIATES
    }
    assert counts["range"] == ["0", "2", "0", "0", "1"]  # bins include the lower edge, the last also the upper one
    assert counts["aspect"] == ["1", "0", "0", "1", "0", "1"]
    assert counts["visible fraction"] == ["0", "2", "0", "0", "1"]
    assert re.findall(r">(bus|car|van|n=\d+)<", errors_by_class(observed).svg) == ["bus", "n=1", "car", "n=2"]


def test_vehicles_with_most_mode_changes_are_shown():
    modes = {1: "cv" * 10, 2: "cvca" * 5, 3: "cv" * 2 + "ca" * 10, 4: "cvca" * 2}
    rows = [(actor, text[k : k + 2]) for actor, text in modes.items() for k in range(0, len(text), 2)]
    rows = [row for row in rows for _ in range(2)]  # two frames each
    judged = pd.DataFrame(rows, columns=["actor_id", "true_mode"])
    judged["true_mode"] = pd.Categorical(judged["true_mode"], MODELS)
    # Vehicle 2 changes nine times, 3 once, 1 never; 4 is followed for too few frames.
    assert most_mode_changes(judged) == [2, 3, 1]
