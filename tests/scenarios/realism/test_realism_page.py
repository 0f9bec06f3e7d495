"""docs/realism.md: its columns, options, files and pictures exist, and its script writes what a comparison found."""

import json
import re
import shutil

import pytest
import typer
from support.paths import DOCS, EXAMPLES
from support.scripts import load_script

from luxloop.scenarios.cli import app
from luxloop.scenarios.files.scenario import Scenario
from luxloop.scenarios.realism.real_table import BANDS, VIEW
from luxloop.scenarios.realism.realism_comparison import FIGURES

PAGE = DOCS / "realism.md"
draw_realism = load_script(DOCS / "draw_realism.py")


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
    assert set(shown) == {*draw_realism.SHOWN, "real_cars"}  # the latter by draw_real_cars.py


def side(value, interval=None, quartiles=(0.1, 0.3)):
    return {"value": value, "interval": interval, "quartiles": list(quartiles), "n": 9}


def folder(path, simulated, verdict):
    figures = {
        "bow_end_0.45_0.75_m": {"real": side(0.165), "simulated": side(simulated, [0.1, 0.2]), "verdict": verdict},
        "best_error_deg": {"real": side(2.65, None, (0.5, 2.0)), "simulated": None, "verdict": "n/a"},
    }
    path.mkdir()
    (path / "realism.json").write_text(json.dumps({"figures": figures}))
    for name in draw_realism.SHOWN:
        (path / f"{name}.png").write_bytes(path.name.encode())
    return path


def test_the_script_replaces_table_and_pictures(tmp_path, monkeypatch):
    page, pictures = tmp_path / "realism.md", tmp_path / "pictures"
    shutil.copy(PAGE, page)
    pictures.mkdir()
    after, before = folder(tmp_path / "after", 0.152, "agrees"), folder(tmp_path / "before", 0.006, "differs")
    monkeypatch.setattr(draw_realism, "PAGE", page)
    monkeypatch.setattr(draw_realism, "PICTURES", pictures)
    monkeypatch.setattr("sys.argv", ["draw_realism.py", "bumper-89", str(after), str(before)])
    draw_realism.main()
    text = page.read_text(encoding="utf-8")
    table = text.split("<!-- bumper-89 -->\n")[1].split("\n<!-- end -->")[0].splitlines()
    assert table == [
        "| figure | real (quartiles) | simulated before [95 %] | simulated after [95 %] | verdict |",
        "|---|---|---|---|---|",
        "| bow end 0.45 to 0.75 m [cm] | 16.5 (10.0 to 30.0) | 0.6 [10.0, 20.0] | 15.2 [10.0, 20.0] | agrees |",
        "| heading error best [deg] | 2.65 (0.5 to 2.0) | n/a | n/a | n/a |",
        "| **agree** | | 0 of 1 | 1 of 1 | |",
    ]
    assert (pictures / "realism_bow.png").read_bytes() == b"after"
    draw_realism.main()
    assert page.read_text(encoding="utf-8") == text
