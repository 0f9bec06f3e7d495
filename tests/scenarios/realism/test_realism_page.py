"""docs/realism.md: its columns, options, files and pictures exist, and its tables show what a comparison found."""

import re

import pytest
import typer
from blocks import realism
from support.paths import DOCS, EXAMPLES

from luxloop.scenarios.cli import app
from luxloop.scenarios.files.scenario import Scenario
from luxloop.scenarios.realism.real_table import BANDS, VIEW
from luxloop.scenarios.realism.realism_comparison import FIGURES, ComparedRow, Summary, bow_figure

PAGE = DOCS / "realism.md"


def section(title):
    return re.search(rf"^## {title}\n(.*?)(?=^## |\Z)", PAGE.read_text(encoding="utf-8"), re.DOTALL | re.MULTILINE)[1]


def test_every_column_is_described():
    described = re.findall(r"`(\w+)`", section("The table of real vehicles"))
    assert set(VIEW) | {figure.name for figure in FIGURES} <= set(described)
    assert set(BANDS) <= set(re.findall(r"`(\w+)`", section("The table of the bow by height")))


def test_every_option_is_described():
    command = typer.main.get_command(app).commands["realism"]
    options = {name for option in command.params for name in option.opts if name.startswith("--")}
    listed = set(re.findall(r"^\| `(--[\w-]+)", PAGE.read_text(encoding="utf-8"), re.MULTILINE))
    assert listed == options


@pytest.mark.parametrize("kind", ["car", "suv"])
@pytest.mark.parametrize("view", ["roof", "bumper"])
def test_the_scenarios_of_both_views_are_valid(view, kind):
    scenario = Scenario.load(EXAMPLES / view / f"{view}-{kind}.toml")
    assert f"docs/examples/{view}/{view}-{kind}.toml" in PAGE.read_text(encoding="utf-8")
    assert scenario.seed == 3


def test_the_page_shows_the_pictures_of_the_script():
    """Another test holds that all pictures of the pages exist."""
    shown = re.findall(r"\(pictures/realism_(\w+)\.png\)", PAGE.read_text(encoding="utf-8"))
    assert set(shown) == {*realism.SHOWN, "real_cars"}


def side(value, interval=None, quartiles=(0.1, 0.3)):
    return Summary(value, interval, quartiles, 9)


def test_a_table_of_a_comparison_by_hand():
    bow = bow_figure("bow_end_0.45_0.75_m", "bow end 0.45 to 0.75 m")
    best = next(figure for figure in FIGURES if figure.name == "best_error_deg")
    rows = [
        ComparedRow(bow, side(0.165), side(0.152, (0.1, 0.2))),
        ComparedRow(best, side(2.65, None, (0.5, 2.0)), None),
    ]
    assert realism.table(rows).splitlines() == [
        "| figure | real (quartiles) | simulated [95 %] | verdict |",
        "|---|---|---|---|",
        "| bow end 0.45 to 0.75 m [cm] | 16.5 (10.0 to 30.0) | 15.2 [10.0, 20.0] | agrees |",
        "| heading error best [deg] | 2.65 (0.5 to 2.0) | n/a | n/a |",
        "| **agree** |  | 1 of 1 |  |",
    ]
