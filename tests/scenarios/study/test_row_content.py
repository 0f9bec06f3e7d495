"""Rows are identified by content: a run is repeated if a file, the tracker's source or a version has changed."""

import json
import shutil
import sys
from pathlib import Path

import pytest
from support.dask_cluster import worker_thread
from support.paths import NETS, ROOT
from support.sweeps import rows, small_study

from luxloop.scenarios.cli import main
from luxloop.scenarios.run import device
from luxloop.scenarios.study import run_content
from luxloop.scenarios.study.design import runs
from luxloop.scenarios.study.run_content import Contents, named_files
from luxloop.scenarios.study.study_file import Study
from luxloop.scenarios.study.sweep_runs import NEW, TAKEN_OVER, combination, why_run

RIG = 'like = "srx_six_lux"\nmodel = "my_unit.toml"\n'
UNIT = 'like = "lux"\nrange_max_m = 150.0\n'
SUMO = {
    "traffic": {"kind": "sumo", "net": "left-hand.net.xml", "routes": ["left-hand.rou.xml"]},
    "rig": {"file": "my_rig.toml"},
}


@pytest.fixture
def folder(tmp_path):
    """Return a folder with a rig, a unit, a net, routes, a SUMO configuration, a recording and two trackers."""
    (tmp_path / "my_rig.toml").write_text(RIG)
    (tmp_path / "my_unit.toml").write_text(UNIT)
    for name in ("left-hand.net.xml", "left-hand.rou.xml"):
        shutil.copyfile(NETS / "left-hand" / name, tmp_path / name)
    files = '<net-file value="left-hand.net.xml"/><route-files value="left-hand.rou.xml, second.rou.xml"/>'
    (tmp_path / "town.sumocfg").write_text(f"<configuration><input>{files}</input></configuration>")
    (tmp_path / "second.rou.xml").write_text("<routes/>")
    (tmp_path / "drive.csv").write_text("time_s,id\n")
    (tmp_path / "mine.py").write_text("import own_filter\nfrom luxloop.tracker.tracker import Tracker\n")
    (tmp_path / "own_filter.py").write_text("GAIN = 0.5\n")
    (tmp_path / "unused.py").write_text("GAIN = 0.5\n")
    return tmp_path


def key(folder, traffic, tracker=device.SHIPPED):
    document = {**SUMO, "traffic": traffic}
    content = Contents(tracker).of(document, folder)
    return run_content.digest(run_content.inputs(document, content)), content


CONFIGURED = {"kind": "sumo", "config": "town.sumocfg"}
REPLAYED = {"kind": "replay", "file": "drive.csv"}


@pytest.mark.parametrize(
    ("traffic", "name"),
    [
        (SUMO["traffic"], "my_rig.toml"),
        (SUMO["traffic"], "my_unit.toml"),
        (SUMO["traffic"], "left-hand.net.xml"),
        (SUMO["traffic"], "left-hand.rou.xml"),
        (CONFIGURED, "town.sumocfg"),
        (CONFIGURED, "left-hand.net.xml"),
        (CONFIGURED, "second.rou.xml"),
        (REPLAYED, "drive.csv"),
    ],
)
def test_a_changed_file_changes_the_key_and_is_named(folder, traffic, name):
    before, content = key(folder, traffic)
    assert key(folder, traffic)[0] == before
    with (folder / name).open("a") as file:
        file.write("\n")
    after, changed = key(folder, traffic)
    assert after != before
    assert run_content.changes(run_content.inputs({}, content), run_content.inputs({}, changed)) == [f"{name} changed"]


@pytest.mark.parametrize(("traffic", "name"), [(REPLAYED, "left-hand.net.xml"), (SUMO["traffic"], "drive.csv")])
def test_a_file_that_the_scenario_does_not_name_has_no_effect(folder, traffic, name):
    before, _ = key(folder, traffic)
    (folder / name).write_text("changed")
    assert key(folder, traffic)[0] == before


def test_a_file_that_is_missing_at_first_changes_the_key_when_it_comes(folder):
    (folder / "drive.csv").rename(folder / "later.csv")
    before, content = key(folder, REPLAYED)
    (folder / "later.csv").rename(folder / "drive.csv")
    _, after = key(folder, REPLAYED)
    assert run_content.changes(run_content.inputs({}, content), run_content.inputs({}, after)) == ["drive.csv is new"]
    assert key(folder, REPLAYED)[0] != before


def test_the_same_content_in_another_folder_has_the_same_key(folder, tmp_path_factory):
    copy = tmp_path_factory.mktemp("elsewhere") / "copy"
    shutil.copytree(folder, copy)
    assert key(copy, SUMO["traffic"])[0] == key(folder, SUMO["traffic"])[0]


@pytest.mark.parametrize("name", ["mine.py", "own_filter.py"])
def test_a_changed_tracker_or_a_module_that_it_imports_changes_the_key(folder, name):
    spec = f"{folder / 'mine.py'}:Tracker"
    before, content = key(folder, REPLAYED, spec)
    (folder / "unused.py").write_text("GAIN = 0.9\n")
    assert key(folder, REPLAYED, spec)[0] == before
    (folder / name).write_text((folder / name).read_text() + "GAIN = 0.9\n")
    after, changed = key(folder, REPLAYED, spec)
    assert after != before
    found = run_content.changes(run_content.inputs({}, content), run_content.inputs({}, changed))
    assert found == ["the tracker's source changed"]


def test_trackers_by_module_and_by_command_have_a_digest(folder, monkeypatch):
    monkeypatch.chdir(folder)
    monkeypatch.delitem(sys.modules, "mine", raising=False)  # of another test
    monkeypatch.setattr(sys, "path", [place for place in sys.path if not Path(place, "mine.py").exists()])
    module, command = run_content.of_tracker("mine:Tracker"), run_content.of_tracker(f"process:sh {folder}/mine.py")
    assert module == run_content.of_tracker(f"{folder / 'mine.py'}:Tracker")
    (folder / "own_filter.py").write_text("GAIN = 0.9\n")
    assert run_content.of_tracker("mine:Tracker") != module
    assert run_content.of_tracker(f"process:sh {folder}/mine.py") != command
    assert run_content.of_tracker("no_such_module:Tracker") == ""
    assert run_content.of_tracker(device.SHIPPED) not in ("", module)


def test_the_shipped_rigs_and_units_are_part_of_luxloop_s_source():
    names = {path.name for folder in run_content.SIMULATION for path in (ROOT / folder).rglob("*.toml")}
    assert {"srx_six_lux.toml", "lux.toml"} <= names
    assert len(run_content.of_simulation()) == 24


def test_texts_that_are_no_files_are_ignored(folder):
    odd = {"a": "x" * 5000 + ".toml", "b": "zero\0byte.toml", "c": ["../", ".", "no.such.file"], "d": 3}
    assert named_files(odd, folder) == ()


def test_an_empty_reason_is_that_of_a_new_run(tmp_path):
    study = Study.load(small_study(tmp_path))
    run = runs(study, device.SHIPPED)[0]
    row = {"seed": 1, "tracker": device.SHIPPED, "noise.dropout.random_rate": 0.0}
    parameters = ["noise.dropout.random_rate"]
    assert why_run(run, {}) == NEW
    assert why_run(run, {combination({**row, "seed": 9}, parameters): "{}"}) == NEW
    older = run.inputs | {"versions": run.inputs["versions"] | {"numpy": "1.0"}}
    why = why_run(run, {combination(row, parameters): json.dumps(older)})
    assert why == f"run again: numpy 1.0 became {run.inputs['versions']['numpy']}"


@pytest.fixture
def sweep(tmp_path, monkeypatch, capfd):
    """Return a function that runs `luxloop sweep` on the small study, and returns its JSON document."""
    monkeypatch.chdir(tmp_path)
    with worker_thread() as scheduler:

        def run(*options: str):
            assert main(["sweep", "small.toml", "--scheduler", scheduler, "--out", "out", "--json", *options]) in (0, 1)
            return json.loads(capfd.readouterr().out)

        yield run


def test_a_sweep_repeats_the_runs_of_a_changed_rig_only(tmp_path: Path, sweep):
    study = small_study(tmp_path, seeds=1)
    text = (tmp_path / "short.toml").read_text()
    (tmp_path / "short.toml").write_text(text.replace("[traffic]", 'rig = { file = "my_rig.toml" }\n[traffic]'))
    (tmp_path / "my_rig.toml").write_text('like = "srx_six_lux"\n')
    assert sweep()["why"] == {NEW: 4}
    again = sweep()
    assert (again["why"], again["taken_up"]) == ({TAKEN_OVER: 4}, 4)
    first = rows(study)
    (tmp_path / "my_rig.toml").write_text('like = "srx_six_lux"\nrear_axle_x_m = -1.0\n')
    changed = sweep()
    assert (changed["why"], changed["taken_up"]) == ({"run again: my_rig.toml changed": 4}, 0)
    assert set(rows(study)["trace_hash"]).isdisjoint(first["trace_hash"])


@pytest.mark.slow
def test_errors_are_repeated_on_request(tmp_path: Path, sweep):
    """A tracker that needs a file outside of its folder, which nothing names."""
    study = small_study(tmp_path, seeds=1)
    study.write_text(study.read_text().replace("[0.0, 0.1, 0.2, 0.3]", "[0.0, 0.1]"))
    flag = tmp_path / "data" / "flag"
    source = "import pathlib\nfrom luxloop.tracker.tracker import Tracker as Shipped\n"
    (tmp_path / "needs.py").write_text(
        f"{source}def Tracker(config):\n    pathlib.Path({str(flag)!r}).stat()\n    return Shipped(config)\n"
    )
    options = ("--tracker", "needs.py:Tracker")
    assert sweep(*options)["status"] == {"error": 2}
    flag.parent.mkdir()
    flag.write_text("")
    assert sweep(*options)["taken_up"] == 2
    mended = sweep(*options, "--retry-errors")
    assert (mended["status"], mended["why"]) == ({"passed": 2}, {"run again: it ended with an error": 2})
    assert len(rows(study)) == 2
    assert sweep(*options, "--retry-errors")["why"] == {TAKEN_OVER: 2}
