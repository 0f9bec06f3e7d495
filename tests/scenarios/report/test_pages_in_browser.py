"""Every page of luxloop in a real browser: nothing wider than the screen, contrast of text and marks, frame player."""

from itertools import product

import pandas as pd
import pytest
from support import browser, short_run
from support import recorded_drive as drive
from support.contrast import AA_TEXT, contrast, too_low
from support.few import few
from support.paths import EXAMPLES

from luxloop.scenarios.cli import main
from luxloop.scenarios.document.palette import TEXT_NAMES, TONES
from luxloop.scenarios.study.study_file import Study
from luxloop.scenarios.study.study_page import report
from luxloop.scenarios.study.sweep_runs import Sweep

EXPECT = """
[expect]
"fit.heading_abs_mean_deg" = { max = 0.001, unit = "deg", need = "a ruler's edge" }
"track.hota" = { min = 1.1, need = "more than perfect" }
"track.idf1" = { min = 0.999, known_failure = "the first frames have no track yet" }
"""
STUDY = """
description = "How long an occlusion may last."
scenario = "luxloop.scenarios.study.staged:hidden_behind_wall"
seeds = 2
[[vary]]
key = "occlusion_s"
label = "hidden [s]"
values = [1.0, 2.0]
[[curve]]
metric = "track.reappearance_error_m"
against = "occlusion_s"
"""
NAMES = ["run", *(pytest.param(name, marks=pytest.mark.slow) for name in
                  ("suite", "trackers", "comparison", "trends", "recording", "sweep"))]  # fmt: skip
"""Pages. All are made of the same parts; `make test` opens that of a run."""
SIZES = {"wide": (1280, 900), "phone": (390, 844)}


def rgb(tone):
    return f"rgb({', '.join(str(int(tone[k : k + 2], 16)) for k in (1, 3, 5))})"


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """The page of a run, and below it the run."""
    folder = tmp_path_factory.mktemp("pages")
    scenario = str(short_run.write(folder, short_run.TEXT + EXPECT, "short"))
    assert main(["run", scenario, "--out", str(folder / "runs" / "shipped"), "--quiet"]) == 1
    assert main(["report", str(folder / "runs" / "shipped"), "--out", str(folder / "run.html")]) == 0
    return folder


def _all_others(folder):
    """Make the pages of `make slow`."""
    near = f"{EXAMPLES / 'ci/my_tracker.py'}:Nearest"
    nearest = ["--tracker", near, "--no-recording", "--quiet"]
    assert main(["run", str(folder / "short.toml"), "--out", str(folder / "runs" / "nearest"), *nearest]) == 1
    runs = [str(folder / "runs" / name) for name in ("shipped", "nearest")]
    assert main(["report", str(folder / "runs"), "--out", str(folder / "suite.html")]) == 0
    both = ["--out", str(folder / "trackers.html"), "--recording", str(folder / "trackers.rrd")]
    assert main(["report", *runs, *both]) == 0
    assert main(["compare", *runs, "--report", str(folder / "comparison.html")]) in (0, 1, 5)
    assert main(["trends", *runs, "--out", str(folder / "trends.html")]) == 0
    _recording(folder)
    _sweep(folder)


def _recording(folder):
    drive.write_ros1(folder / "drive.bag")
    assert main(["import", str(folder / "drive.bag"), "--out", str(folder / "recorded"), *drive.OPTIONS]) == 0
    assert main(["track", str(folder / "recorded"), "--out", str(folder / "tracked")]) == 0
    (folder / "tracked" / "report.html").rename(folder / "recording.html")


def _sweep(folder):
    path = folder / "small.toml"
    path.write_text(STUDY, encoding="utf-8")
    rows = pd.DataFrame(
        {"index": index, "key": str(index), "occlusion_s": time, "seed": seed, "status": "passed", "error": "",
         "wall_s": 1.0, "track.reappearance_error_m": time * seed}
        for index, (time, seed) in enumerate(product((1.0, 2.0), (1, 2)))
    )  # fmt: skip
    report(Sweep(Study.load(path), rows, 4), folder / "sweep").rename(folder / "sweep.html")


@pytest.fixture(scope="module")
def chromium():
    with browser.started() as found:
        yield found


def opened(chromium, folder, name, size="wide", **options):
    width, height = size if isinstance(size, tuple) else SIZES[size]
    if not (folder / f"{name}.html").exists():
        _all_others(folder)
    return browser.opened(chromium, folder / f"{name}.html", viewport={"width": width, "height": height}, **options)


@pytest.mark.parametrize("size", SIZES)
@pytest.mark.parametrize("name", NAMES)
def test_nothing_is_wider_than_the_screen(chromium, folder, name, size):
    """Fails when something makes the page scroll sideways, or, on a wide screen, does not fit its own box."""
    with opened(chromium, folder, name, size) as page:
        page.evaluate("document.querySelectorAll('details').forEach(one => one.open = true)")
        width = "[document.documentElement.scrollWidth, document.documentElement.clientWidth]"
        shown, room = page.evaluate(width)
        assert shown <= room == SIZES[size][0]
        if size == "wide":
            assert browser.cut_off(page) == []
        assert page.recorded == []


@pytest.mark.parametrize("name", NAMES)
def test_nothing_is_wider_than_a_printed_sheet(chromium, folder, name):
    room = 688  # A4 less its margins, at 96 dots per inch
    with opened(chromium, folder, name, (room, 1000)) as page:
        page.emulate_media(media="print")
        assert page.evaluate("document.documentElement.scrollWidth") <= room
        beyond = (
            "all => all.filter(one => one.getBoundingClientRect().right > innerWidth + 1).map(one => one.outerHTML)"
        )
        assert page.locator("table, figure, svg").evaluate_all(beyond) == []


@pytest.mark.parametrize("scheme", few(["light", "dark"], "light"))
@pytest.mark.parametrize("name", NAMES)
def test_contrast_of_every_text_and_mark_meets_wcag_aa(chromium, folder, name, scheme):
    tone = {key: rgb(getattr(value, scheme)) for key, value in TONES.items()}
    with opened(chromium, folder, name, color_scheme=scheme) as page:
        assert too_low(page, [tone["line"], tone["panel"]], on_marks=tone["page"]) == []


def test_contrast_of_text_on_marks():
    """Text in the page's colour is only on marks in these colours."""
    assert contrast("#000000", "rgb(255, 255, 255)") == pytest.approx(21.0)
    assert contrast("#777777", "#ffffff") == pytest.approx(4.48, abs=0.005)  # the grey that just fails
    for scheme in ("light", "dark"):
        page = getattr(TONES["page"], scheme)
        for name in (*TEXT_NAMES, "ink"):
            assert contrast(page, getattr(TONES[name], scheme)) >= AA_TEXT, (scheme, name)


def frame(page):
    return int(page.locator("#player output").inner_text().split()[1])


@pytest.mark.parametrize("name", ["run", pytest.param("trackers", marks=pytest.mark.slow)])
def test_frames_are_stepped_and_zoomed_without_a_network(chromium, folder, name):
    """Fails when a key, a button, the wheel or a link does not work, or the page asks for another file."""
    with opened(chromium, folder, name) as page:
        page.wait_for_selector("#player canvas", state="visible")
        page.locator("#player [data-do=first]").click()
        assert frame(page) == 0
        canvas = page.locator("#player canvas")
        canvas.focus()
        for key, expected in (("ArrowRight", 1), ("ArrowRight", 2), ("ArrowLeft", 1), ("End", 9), ("ArrowRight", 9)):
            canvas.press(key)
            assert frame(page) == expected
        before = canvas.screenshot()
        page.mouse.move(*_middle(canvas))
        page.mouse.wheel(0, -600)
        page.wait_for_timeout(100)
        zoomed = canvas.screenshot()
        page.locator("#player [data-do=all]").click()
        assert canvas.screenshot() == before != zoomed
        link = page.locator("a.step").first
        link.click()
        assert frame(page) == int(link.get_attribute("data-frame"))
        assert page.recorded == []


def _middle(canvas):
    box = canvas.bounding_box()
    return box["x"] + box["width"] / 2, box["y"] + box["height"] / 2


def test_points_of_all_frames_come_from_the_recording(chromium, folder):
    """The run keeps the points of few frames in its tables; those between are read from its recording."""
    with opened(chromium, folder, "run") as page:
        page.wait_for_selector("#player canvas", state="visible")
        for number in range(10):
            page.locator("#player input[type=range]").fill(str(number))
            assert "not in the page" not in page.locator("#player output").inner_text()


@pytest.mark.slow
def test_layers_can_be_switched_off(chromium, folder):
    with opened(chromium, folder, "trackers") as page:
        page.wait_for_selector("#player canvas", state="visible")
        page.locator("#player [data-do=last]").click()
        canvas, pictures = page.locator("#player canvas"), []
        for box in page.locator("#player [data-part]").all():
            pictures.append(canvas.screenshot())
            box.uncheck()
        pictures.append(canvas.screenshot())
        assert len(pictures) == 6
        assert pictures[0] != pictures[1]  # points
        assert pictures[1] != pictures[2]  # true boxes
        assert pictures[4] != pictures[5]  # the tracks of the second tracker


def test_failed_expectations_lead_to_pictures_of_their_frames(chromium, folder):
    with opened(chromium, folder, "run") as page:
        rows = page.locator("#expectations tbody tr").filter(has_text="fit.heading_abs_mean_deg")
        links = rows.locator("a").all()
        assert links
        for link in links:
            target = link.get_attribute("href")
            number = int(target.rpartition("-")[2])
            assert f"frame {number} " in link.inner_text()
            caption = page.locator(f'[id="{target[1:]}"] figcaption').inner_text()
            assert f"Frame {number}," in caption
            assert "fit.heading_abs_mean_deg" in caption
            assert ": heading error " in caption
