"""Plug-ins: the example package of the documentation, and packages with defects."""

import json
import re
import shlex
import tomllib
from importlib.metadata import version

import pytest
from support import box_files, plugin_package
from support.few import few
from support.pages import chapter
from support.paths import ROOT

from luxloop import plugins
from luxloop.plugins import ABILITIES, FORMATS, PluginError, PluginGroup, formats_that
from luxloop.scenarios.run.device import TRACKERS
from luxloop.sim.factory import KINDS

PAGE = chapter("own-tracker.md", "Plug-ins")
EXAMPLE = ROOT / "docs" / "examples" / "plugin"
ENTRY_POINTS = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]["entry-points"]
GROUPS = (KINDS, FORMATS, TRACKERS)
SCENARIO = 'description = "Traffic of a plug-in."\nduration_s = 1\n[traffic]\nkind = "%s"\n'
WRONG = {
    "absent": ("broken", "raise RuntimeError('two\\nlines')", "cannot be loaded (RuntimeError: two lines)"),
    "wrong": ("broken:NUMBER", "NUMBER = 5", "should be "),
    "nameless": ("broken:NUMBER", "", "cannot be loaded (AttributeError: "),
}
"""Values of entry points, the modules that they name, and what is wrong with them."""


@pytest.fixture(scope="module")
def example(tmp_path_factory):
    folder = tmp_path_factory.mktemp("installed")
    plugin_package.install_example(folder)
    return folder


@pytest.mark.parametrize("group", GROUPS, ids=lambda group: group.name)
def test_luxloops_own_plugins_are_those_of_its_project_file_and_can_be_loaded(group):
    assert group.names(of_luxloop=True) == [*group.core, *sorted(ENTRY_POINTS[group.name])]
    assert list(group.load_all()) == group.names()
    assert all(group.check(name, group.load(name)) == "" for name in group.names())


def test_every_ability_has_a_format_and_is_on_the_page():
    for ability in ABILITIES:
        assert formats_that(ability)
        assert f"| `{ability}`" in PAGE


def test_the_entry_points_on_the_page_are_those_of_the_example():
    shown = tomllib.loads(re.search(r"```toml\n(.*?)```", PAGE, re.DOTALL)[1])["project"]["entry-points"]
    assert shown == tomllib.loads((EXAMPLE / "pyproject.toml").read_text(encoding="utf-8"))["project"]["entry-points"]


@pytest.mark.slow
def test_the_commands_of_the_page_use_the_example(example, tmp_path):
    (tmp_path / "docs").symlink_to(ROOT / "docs")
    install, *commands = re.search(r"```sh\n(.*?)```", PAGE, re.DOTALL)[1].splitlines()
    assert install == "pip install docs/examples/plugin"  # `install_example` does it without network
    results = plugin_package.luxloop(example, tmp_path, *(shlex.split(command)[1:] for command in commands))
    run, grade, _ = results
    assert [(each.code, each.error) for each in results] == [(0, "")] * 3
    assert "circling.tracker:PatchTracker" in run.out
    assert re.search(r"track\.mota +1\.000 ", grade.out)
    rows = json.loads((tmp_path / "league" / "league.json").read_text(encoding="utf-8"))["rows"]
    assert {row["tracker"] for row in rows} == {"patches", "shipped"}
    assert {row["status"] for row in rows} == {"finished"}


@pytest.mark.slow
def test_the_run_of_a_plugin_is_graded_again_and_needs_the_plugin(example, tmp_path):
    run = ["run", str(EXAMPLE / "circle.toml"), "--no-recording", "--json", "-q", "--record-scans", "--out", "run"]
    first, again = plugin_package.luxloop(example, tmp_path, run, ["grade", "run", "--json"])
    result = json.loads((tmp_path / "run" / "result.json").read_text(encoding="utf-8"))
    assert result["versions"]["luxloop-circling"] == "1.0"
    hota = [json.loads(each.out)["metrics"]["track.hota"]["value"] for each in (first, again)]
    assert hota[0] == hota[1] > 0.3
    (without,) = plugin_package.luxloop(tmp_path, tmp_path, ["grade", "run"])
    assert without.code == 2
    assert 'traffic.kind = "circle" is of a plug-in that is not installed; install it' in without.error


def test_keys_of_a_plugin_are_checked_and_its_names_listed(example, tmp_path):
    (tmp_path / "a.toml").write_text(SCENARIO % "circle" + "radius = 5\n")
    (tmp_path / "b.toml").write_text(SCENARIO % "circel")
    wrong_key, wrong_kind, wrong_tracker = plugin_package.luxloop(
        example, tmp_path, ["run", "a.toml"], ["run", "b.toml"], ["run", "ring", "--tracker", "patch"]
    )
    assert "a.toml: traffic.radius = 5: unknown key; did you mean radius_m?" in wrong_key.error
    assert "'openscenario'" in wrong_kind.error
    assert "'circle'" in wrong_kind.error
    assert wrong_tracker.code == 2
    assert "patches" in wrong_tracker.error


@pytest.mark.parametrize("defect", few(WRONG, next(iter(WRONG))))
def test_a_defective_plugin_is_named_in_one_line_and_stops_no_other_command(defect, tmp_path):
    value, code, reason = WRONG[defect]
    plugin_package.write(tmp_path, "broken", {group.name: {"broken": value} for group in GROUPS}, code)
    (tmp_path / "a.toml").write_text(SCENARIO % "broken")
    box_files.write(tmp_path, "truth.csv", box_files.csv(box_files.drive(3)[0]))
    grade = ["grade", "--truth", "truth.csv", "--tracks", "truth.csv"]
    asking = {
        "luxloop.traffic": ["run", "a.toml"],
        "luxloop.trackers": ["run", "ring", "--tracker", "broken"],
        "luxloop.formats": [*grade, "--truth-format", "broken"],
    }
    *asked, other, listed = plugin_package.luxloop(tmp_path, tmp_path, *asking.values(), [*grade, "--json"], ["list"])
    for group, ended in zip(asking, asked, strict=True):
        assert (ended.code, ended.out, ended.error.count("\n")) == (2, "", 1)
        why = "cannot be loaded (" if group == "luxloop.trackers" else reason  # it is loaded by a process of its own
        assert f'plug-in broken 1.0 ({group}: broken = "{value}") {why}' in ended.error
    assert other.code == 0
    assert json.loads(other.out)["metrics"]["track.mota"]["value"] == 1.0
    assert other.error.startswith('luxloop: warning: plug-in broken 1.0 (luxloop.formats: broken = "')
    assert other.error.count("\n") == 1
    assert (listed.code, listed.error) == (0, "")


@pytest.mark.slow
def test_a_name_that_is_registered_twice_is_refused(tmp_path):
    names = {"luxloop.traffic": {"sumo": "second:X"}, "luxloop.formats": {"kitti": "second"}}
    plugin_package.write(tmp_path, "second", names)
    taken, twice = plugin_package.luxloop(
        tmp_path, tmp_path, ["run", "sumo-crossing"], ["export", "run", "--format", "kitti", "--out", "new"]
    )
    assert taken.code == 2
    assert 'plug-in second 1.0 (luxloop.traffic: sumo = "second:X") has the name of luxloop itself' in taken.error
    assert (twice.code, twice.error.count("\n")) == (2, 1)
    assert 'plug-in second 1.0 (luxloop.formats: kitti = "second")' in twice.error
    own = f"plug-in luxloop {version('luxloop')}"
    assert f'{own} (luxloop.formats: kitti = "luxloop.scenarios.exchange.kitti")' in twice.error


def test_missing_entry_points_of_luxloop_are_reported(monkeypatch, capsys):
    plugins._warn.cache_clear()
    monkeypatch.setattr(plugins, "_registered", lambda _group: ())
    assert PluginGroup("luxloop.other", lambda _name, _found: "").load_all() == {}
    assert capsys.readouterr().err == (
        "luxloop: warning: luxloop's own entry points of luxloop.other are not installed; install luxloop again\n"
    )
    plugins._warn.cache_clear()


def test_a_member_of_the_core_needs_no_registration(monkeypatch):
    monkeypatch.setattr(plugins, "_registered", lambda _group: ())
    group = PluginGroup("luxloop.other", lambda _name, _found: "a text", core={"own": PluginError})
    assert group.load("own") is PluginError
    assert group.place("own") == "luxloop.plugins:PluginError"
