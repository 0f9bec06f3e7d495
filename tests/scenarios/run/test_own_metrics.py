"""Metrics of scenario and study files: actors chosen by hand, functions, their errors, and what depends on them."""

import json
import sys

import pandas as pd
import pytest
from support import short_run
from support.few import few
from support.frames import Body, Scripted, follow, grade_run
from support.optional import need
from support.paths import without_checkouts

from luxloop.scenarios.cli import main
from luxloop.scenarios.errors import MetricError, ScenarioError, StudyError
from luxloop.scenarios.files.scenario import Scenario
from luxloop.scenarios.grading import figures
from luxloop.scenarios.metrics.own_metric import OwnMetric
from luxloop.scenarios.report.text import as_text, report
from luxloop.scenarios.run import child_process, own_metrics
from luxloop.scenarios.study import design
from luxloop.scenarios.study.study_file import Study
from luxloop.scenarios.study.worker import carry_out
from luxloop.sim.world import Kind

FUNCTIONS = """
import sys
def nearest(tables):
    truth = tables["truth"]
    return truth.loc[truth["graded"], "range_m"].min()
def none(tables):
    tables["truth"]["graded"] = False
def text(tables):
    return "near"
def infinite(tables):
    return 1e400
def fails(tables):
    return tables["truth"]["no such\\ncolumn"]
def leaves(tables):
    sys.exit("done")
def ends(tables):
    import os
    os._exit(0)
def lasts(tables):
    import signal
    signal.pause()
def prints(tables):
    print("hello")
    return 1.0
def forges(tables):
    import gc
    from luxloop.scenarios.result import Metric
    return float(sum(isinstance(item, Metric) for item in gc.get_objects()))
NUMBER = 3
def digits(tables):
    return b"12"
class Silent(BaseException):
    def __str__(self):
        sys.exit(0)
def silent(tables):
    raise Silent
class Ends:
    def __float__(self):
        sys.exit(0)
def ends_later(tables):
    return Ends()
"""


@pytest.fixture
def functions(tmp_path, monkeypatch):
    """The name of a module of functions in the current folder."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "path", [*sys.path, str(tmp_path)])
    (tmp_path / "own_functions.py").write_text(FUNCTIONS, encoding="utf-8")
    yield "own_functions"
    sys.modules.pop("own_functions", None)


def graded(*metrics):
    """Own metrics of two cars and a truck, tracked 0.1, 0.3 and 0.5 m off; the second car is missed in one frame."""
    kinds = (Kind.CAR, Kind.CAR, Kind.TRUCK)
    scene = [[Body(k, 12.0, 8.0 * (k - 1), speed=5.0, kind=kinds[k]) for k in range(3)]] * 4
    script = [
        [follow(body, x=body.x + 0.1 + 0.2 * body.id) for body in bodies if (body.id, frame) != (1, 3)]
        for frame, bodies in enumerate(scene)
    ]
    figures, tables, _ = grade_run(scene, Scripted(script))
    return own_metrics.grade([OwnMetric.model_validate(one) for one in metrics], tables, figures, 4)


def of(metric, **chosen):
    return {"name": "own.figure", "of": metric, **chosen}


def test_only_the_chosen_actors_count():
    position = "mma.x_abs_mean_m{target=moving}"
    assert graded(of(position, **{"class": "truck"}))["own.figure"].value == pytest.approx(0.5)
    cars = graded(of(position, **{"class": ["car", "van"]}))["own.figure"]
    assert (cars.value, cars.n) == (pytest.approx((4 * 0.1 + 3 * 0.3) / 7), 7)
    assert graded(of("track.missed", **{"class": "car"}))["own.figure"].value == 1
    assert graded(of("track.missed", **{"class": "truck"}))["own.figure"].value == 0


def test_actors_that_are_not_there_have_a_reason():
    assert graded(of("track.hota", actor="lorry"))["own.figure"].reason == 'no actor is named "lorry"'
    bus = graded(of("track.hota", **{"class": "bus"}))["own.figure"]
    assert (bus.value, bus.n, bus.reason) == (None, 0, "no actor of class bus")


def test_a_name_chooses_one_actor():
    result = short_run.result()
    tables = result.tables
    first, second = pd.unique(tables["truth"]["name"])[:2]
    one = figures.restricted(result.metrics.run, {"actor": first}).tables
    assert set(one["truth"].loc[one["truth"]["graded"], "name"]) == {first}
    assert second not in set(one["emergence"]["name"])
    assert len(one["fits"]) < len(tables["fits"])


def test_functions_get_the_tables_and_cannot_change_the_run(functions):
    result = short_run.result()
    before = result.tables["truth"]["graded"].sum()
    metrics = [
        OwnMetric(name="own.nearest_m", function=f"{functions}:nearest", unit="m"),
        OwnMetric(name="own.none", function=f"{functions}:none"),
    ]
    found = own_metrics.grade(metrics, result.tables, result.metrics, result.frames)
    truth = result.tables["truth"]
    assert found["own.nearest_m"].value == truth.loc[truth["graded"], "range_m"].min()
    assert found["own.nearest_m"].unit == "m"
    assert (found["own.none"].value, found["own.none"].reason) == (None, "own_functions:none returned no value")
    assert result.tables["truth"]["graded"].sum() == before


@pytest.mark.usefixtures("functions")
@pytest.mark.parametrize(
    ("function", "message"),
    few([
        ("own_functions:text", "own.x: own_functions:text returned a str, no number"),
        ("own_functions:infinite", "own.x: own_functions:infinite returned inf; return None"),
        (
            "own_functions:fails",
            r"own_functions:fails: .*own_functions.py, line 13: KeyError: 'no such.*column'",
        ),
        ("own_functions:ends", "functions own_functions:ends: their process ended with exit code 0"),
        ("own_functions:lasts", "functions own_functions:lasts: took more than 8 s"),
        ("own_functions:leaves", "own.x: own_functions:leaves: .*line 15: SystemExit: done"),
        (
            "own_functions:nothing",
            "own.x: function = own_functions:nothing: nothing is not there in own_functions; name a function",
        ),
        ("own_functions:NUMBER", "own.x: function = own_functions:NUMBER: NUMBER is not callable in own_functions"),
        ("no_such_module:f", "own.x: function = no_such_module:f: no module no_such_module on the Python path"),
        (
            "scenarios.grading.grader:f",
            r"function = .*no module scenarios.*; luxloop's module is luxloop\.scenarios\.grading\.grader now",
        ),
    ], "own_functions:text", "own_functions:ends"),
)  # fmt: skip
def test_errors_of_functions_are_one_line(function, message, monkeypatch):
    monkeypatch.setattr(sys, "path", without_checkouts(sys.path))
    if "lasts" in function:
        monkeypatch.setattr(own_metrics, "LIMIT_S", 8.0)
    with pytest.raises(MetricError, match=message) as raised:
        own_metrics.grade([OwnMetric(name="own.x", function=function)], short_run.result().tables, {}, 10)
    assert "\n" not in str(raised.value)


@pytest.mark.parametrize(
    ("function", "answer"),
    [("digits", {"type": "bytes"}), ("silent", {"error": "line 36: Silent"}), ("ends_later", {"type": "Ends"})],
)
def test_odd_errors_and_values_do_not_end_the_process_of_functions(functions, tmp_path, function, answer):
    request = ({"own.x": f"{functions}:{function}"}, str(tmp_path), {"truth": pd.DataFrame()})
    (found,) = own_metrics.values(request).values()
    ((key, text),) = answer.items()
    assert list(found) == [key]
    assert found[key].endswith(text)


@pytest.mark.parametrize(
    "answer",
    [[1], "own.x", {}, {"own.x": 3}, {"own.x": [["value", "1.5"]]}, {"own.x": {"value": 10**400}}, {"own.x": None}],
)
def test_an_answer_that_is_no_number_is_one_line(answer, monkeypatch):
    monkeypatch.setattr(child_process, "ask", lambda *_: answer)
    with pytest.raises(MetricError):
        own_metrics.grade([OwnMetric(name="own.x", function="some:function")], {}, {}, 10)


def test_a_function_neither_prints_on_standard_output_nor_finds_other_metrics(functions, capfd):
    chosen = [OwnMetric(name=f"own.{name}", function=f"{functions}:{name}") for name in ("prints", "forges")]
    found = own_metrics.grade(chosen, short_run.result().tables, short_run.result().metrics, 10)
    assert (found["own.prints"].value, found["own.forges"].value) == (1.0, 0.0)
    assert capfd.readouterr() == ("", "hello\n")


METRICS = """
[[metric]]
name = "own.nearest_m"
function = "own_functions:nearest"
unit = "m"
meaning = "least range of a graded vehicle"
[[metric]]
name = "own.cars_hota"
of = "track.hota"
class = "car"
[expect]
"own.nearest_m" = { min = 1.0, unit = "m" }
"own.cars_hota" = { min = 2.0 }
"""


@pytest.mark.usefixtures("functions")
def test_a_run_has_them_in_expectations_report_and_pages_with_the_same_trace(tmp_path, capsys):
    short_run.write(tmp_path, short_run.TEXT + METRICS, "own")
    assert main(["run", "own.toml", "--no-recording", "--out", "run"]) == 1  # HOTA is below 2
    capsys.readouterr()
    document = json.loads((tmp_path / "run" / "result.json").read_text(encoding="utf-8"))
    assert document["trace_hash"] == short_run.result().trace_hash
    assert document["failed"] == ["own.cars_hota"]
    assert document["metrics"]["own.nearest_m"]["value"] > 1.0
    assert document["metrics"]["own.cars_hota"]["value"] == document["metrics"]["track.hota"]["value"]
    assert "least range of a graded vehicle" in (tmp_path / "run" / "report.txt").read_text(encoding="utf-8")
    assert main(["report", "run"]) == 0
    assert "own.nearest_m" in (tmp_path / "run.html").read_text(encoding="utf-8")
    assert main(["grade", "run"]) == 1
    assert "own.cars_hota" in capsys.readouterr().out
    assert main(["compare", "run", "run"]) == 0


@pytest.mark.usefixtures("functions")
def test_a_missing_function_is_reported_before_the_run(tmp_path, capsys):
    text = short_run.TEXT + METRICS.replace("own_functions:nearest", "own_functions:farthest")
    short_run.write(tmp_path, text, "own")
    assert main(["run", "own.toml", "--out", "run"]) == 2
    assert "own.nearest_m: function = own_functions:farthest" in capsys.readouterr().err
    assert not (tmp_path / "run").exists()


def test_a_report_without_own_metrics_has_no_table_of_them():
    assert "Metrics of the scenario" not in as_text(report(short_run.result(), []))


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (('of = "track.hota"', 'of = "track.hotta"'), 'of = "track.hotta": unknown metric; did you mean track.hota'),
        (
            ('of = "track.hota"', 'of = "outliers.recall{cause=rain}"'),
            "no metric of single actors; it cannot be restricted to a class",
        ),
        (('class = "car"', 'class = "cra"'), 'class = "cra": no class of actors; name one of car'),
        (('class = "car"', ""), "give actor or class, or use track.hota itself"),
        (('class = "car"', 'class = "car"\nunit = "m"'), "leave it out"),
        (('class = "car"', 'class = "car"\nfunction = "a:b"'), "give either of"),
        (('unit = "m"\nmeaning', 'actor = "a"\nmeaning'), "actor and class belong to of"),
        (('"own_functions:nearest"', '"nearest"'), "should be MODULE:FUNCTION"),
        (('name = "own.cars_hota"', 'name = "cars_hota"'), "should begin with own."),
        (('name = "own.cars_hota"', 'name = "own.nearest_m"'), "own.nearest_m is defined twice"),
        (
            ('"own.nearest_m" =', '"own.narest_m" ='),
            "of this file has this name; name one of own.nearest_m",
        ),
        (('unit = "m" }', 'unit = "deg" }'), 'the metric is in "m"'),
    ],
)
def test_invalid_tables_are_one_line(change, message, tmp_path):
    path = short_run.write(tmp_path, short_run.TEXT + METRICS.replace(*change), "own")
    with pytest.raises(ScenarioError, match=message) as raised:
        Scenario.load(path)
    assert "\n" not in str(raised.value)


STUDY = """
description = "Own metrics."
scenario = "luxloop.scenarios.study.staged:standing_car"
seeds = 2
[[vary]]
key = "range_m"
low = 12.0
high = 20.0
steps = 2
neutral = 12.0
[[metric]]
name = "own.nearest_m"
function = "own_functions:nearest"
unit = "m"
[[curve]]
metric = "own.nearest_m"
against = "range_m"
[search]
metric = "own.nearest_m"
max = 15.0
"""


def write_study(folder, text=STUDY):
    (folder / "study.toml").write_text(text, encoding="utf-8")
    return Study.load(folder / "study.toml")


@pytest.mark.usefixtures("functions")
def test_a_study_adds_them_to_every_run_and_to_its_inputs(tmp_path):
    study = write_study(tmp_path)
    run, *_ = design.runs(study, "luxloop.tracker.tracker:Tracker")
    assert run.inputs["files"].keys() == {"own_functions:nearest"}
    row = carry_out(run)
    assert row["own.nearest_m"] == pytest.approx(12.0, abs=0.5)
    (tmp_path / "own_functions.py").write_text(FUNCTIONS + "\n# changed\n", encoding="utf-8")
    assert design.runs(study, "luxloop.tracker.tracker:Tracker")[0].key != run.key
    assert study.definition("own.nearest_m").unit == "m"
    assert study.search.limit.max == 15.0


@pytest.mark.slow
@pytest.mark.usefixtures("functions")
def test_the_report_of_a_sweep_shows_them(tmp_path):
    need("sweeps")
    write_study(tmp_path)
    assert main(["sweep", "study.toml", "--workers", "1", "--out", "out"]) == 0
    page = (tmp_path / "out" / "report.html").read_text(encoding="utf-8")
    assert "own.nearest_m [m]" in page
    assert pd.read_parquet(tmp_path / "out" / "runs.parquet")["own.nearest_m"].between(11.5, 20.5).all()


@pytest.mark.parametrize("wrong", ["curve", "search"])
def test_curves_and_searches_name_metrics_of_the_study(wrong, tmp_path):
    head, mark, rest = STUDY.partition(f"[{wrong}]")
    with pytest.raises(StudyError, match=r"own.far: no .* of this file has this name"):
        write_study(tmp_path, head + mark + rest.replace("own.nearest_m", "own.far", 1))
