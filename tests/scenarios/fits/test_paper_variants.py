"""The paper's tables of both trackers: pooled runs against single ones, and the page."""

import re
import shutil
from dataclasses import replace

import numpy as np
import pytest
from support import short_run
from support.paths import DOCS, ROOT
from support.scripts import load_script
from variants import tables
from variants.pooled import pooled

from luxloop.scenarios.metrics.definition import filtered
from luxloop.scenarios.metrics.definitions import DEFINITIONS, FIT_METHODS, TARGETS, VIEWS
from luxloop.scenarios.run import run_folder

script = load_script(ROOT / "docs" / "paper_variants.py")
PAGE = DOCS / "paper.md"
FITS = [name for name in DEFINITIONS if name.startswith(("fit.heading", "fit.within"))]
GRADED = [
    *(name for name in DEFINITIONS if name.startswith(("dataset.", "fit."))),
    *(filtered(name, method=method, view=view) for name in FITS for method in FIT_METHODS for view in VIEWS.values()),
    *(f"mma.x_abs_{figure}_m{{target={target}}}" for figure in ("mean", "std") for target in TARGETS),
    *(f"mma.y_abs_{figure}_m{{model=cv,target={target}}}" for figure in ("mean", "std") for target in TARGETS),
]
"""Metrics of the page's tables."""


def test_one_run_has_its_own_metrics_and_intervals():
    result = short_run.result()
    found = pooled([result]).metrics
    assert len(GRADED) > 300
    for name in GRADED:
        assert found[name] == replace(result.metrics[name], reason=found[name].reason), name


def test_runs_are_graded_over_all_their_vehicles():
    """The second run has other errors of the same vehicles, which count as other vehicles."""
    one = short_run.result()
    fits = one.tables["fits"]
    turned = fits.assign(heading_error_deg=fits["heading_error_deg"] + 2.0)
    worse = replace(one, seed=5, tables={**one.tables, "fits": turned})
    single, other, both = (pooled(runs).metrics for runs in ([one], [worse], [one, worse]))
    name = "fit.heading_abs_mean_deg"
    assert both[name].value == pytest.approx(0.5 * (single[name].value + other[name].value))
    assert both[name].n == 2 * single[name].n
    assert both["dataset.vehicles"].value == 2 * single["dataset.vehicles"].value
    assert both["dataset.observations_per_vehicle"].value == single["dataset.observations_per_vehicle"].value
    low, high = both[name].interval
    assert high - low > 0.5  # vehicles of the two runs differ by almost 2 degrees
    errors = np.concatenate([run.tables["fits"].loc[fits["best"], "heading_error_deg"] for run in (one, worse)])
    assert both["fit.heading_std_deg"].value == pytest.approx(errors.std())


def trackers():
    one = short_run.result()
    return {name: {"seed 1": pooled([one]), "two seeds": pooled([one, one])} for name in script.TRACKERS}


def cells(table, *beginning):
    """Cells of the rows that begin so."""
    rows = [line.strip("| ").split(" | ") for line in table.splitlines()]
    return [row[len(beginning) :] for row in rows if tuple(row[: len(beginning)]) == beginning]


def test_tables_show_metrics_with_intervals_and_the_paper_s_figures():
    runs, metrics = trackers(), short_run.result().metrics
    assert cells(tables.table_1(runs), "vehicles") == [["2", "2", "60"]]
    assert cells(tables.table_1(runs), "view: rear")[0][-1] == "3.8%"
    (shown,) = cells(tables.table_2(runs), "`closeness`", "default")
    names = ("mean", "std", "abs_mean", "abs_std")
    mean, std, size, size_std = (metrics[f"fit.heading_{name}_deg{{method=closeness}}"] for name in names)
    assert shown[0] == f"{mean.value:.3f}, {std.value:.3f}"
    assert size.interval is None  # two vehicles
    assert shown[1] == f"{size.value:.3f} [too few vehicles], {size_std.value:.3f}"
    low, high = runs[next(iter(runs))]["two seeds"].metrics["fit.heading_abs_mean_deg{method=closeness}"].interval
    assert shown[3] == f"{size.value:.3f} [{low:.3f}, {high:.3f}], {size_std.value:.3f}"  # four vehicles
    assert shown[4:] == ["0.007, 3.647", "2.007, 3.040"]
    assert cells(tables.table_3(runs), "`best`", "the paper's")[0][1:] == [
        *("23.4 %", "60.0 %", "86.9 %", "96.5 %", "96.5 %", "99.3 %")
    ]
    assert cells(tables.table_3(runs), "`variance`", "default", "seed 1")[0][0].startswith(
        f"{100 * metrics['fit.rounded_to_0deg{method=variance}'].value:.1f} %"
    )
    assert cells(tables.table_4(runs), "moving", "MMA")[0][1:3] == ["0.238, 0.140", "0.163, 0.120"]
    (cv, other) = cells(tables.table_4(runs), "moving", "`cv`")
    assert (cv[0], other[0]) == ("default", "the paper's steps")
    assert cv[1].startswith(f"{metrics['mma.x_abs_mean_m{model=cv,target=moving}'].value:.3f}")


@pytest.mark.parametrize("name", script.TABLES)
def test_the_page_has_the_tables_of_both_trackers(name):
    (shown,) = re.findall(rf"<!-- {name} -->\n(.*?)<!-- end -->", PAGE.read_text(encoding="utf-8"), re.DOTALL)
    made = script.TABLES[name](trackers())
    heads = [text.splitlines()[0].replace("two seeds", "seeds 11 to 13") for text in (shown, made)]
    assert heads[0] == heads[1]
    first = [[row.split(" | ")[:2] for row in text.splitlines()[2:]] for text in (shown, made)]
    if name != "table 1":
        assert first[0] == first[1]


def write_runs(folder, pairs):
    for scenario, seed in pairs:
        out = folder / f"{scenario}-{seed}"
        out.mkdir()
        run_folder.write(out, replace(short_run.result(), scenario=scenario, seed=seed), [], "")


def all_runs():
    seeds = [seed for group in script.SEEDS.values() for seed in group]
    return [(scenario, seed) for scenario in script.TRACKERS.values() for seed in seeds]


def run_script(monkeypatch, *words):
    monkeypatch.setattr("sys.argv", ["paper_variants.py", *map(str, words)])
    script.main()


def test_the_command_writes_the_page(tmp_path, capsys, monkeypatch):
    runs, page = tmp_path / "runs", tmp_path / "paper.md"
    runs.mkdir()
    write_runs(runs, [*all_runs(), ("ring", 1)])
    page.write_text("".join(f"<!-- {name} -->\nearlier table\n<!-- end -->\n" for name in script.TABLES))
    run_script(monkeypatch, runs, "--page", page)
    printed, written = capsys.readouterr().out, page.read_text(encoding="utf-8")
    for table in re.findall(r"<!-- table \d -->\n(.*?)<!-- end -->", written, re.DOTALL):
        assert table.count("\n|") > 5
        assert table in printed
    assert "earlier table" not in written


def test_missing_double_and_shorter_runs_are_one_line_errors(tmp_path, monkeypatch):
    write_runs(tmp_path, all_runs()[:-1])
    command = "luxloop run docs/examples/paper-variant.toml --seed 13"
    with pytest.raises(SystemExit, match=f"no run of paper-variant with seed 13; make it by: {command}"):
        run_script(monkeypatch, tmp_path)
    again = tmp_path / "again"
    again.mkdir()
    write_runs(again, [("paper-campus", 1)])
    with pytest.raises(SystemExit, match="a second run of paper-campus with seed 1"):
        run_script(monkeypatch, tmp_path)
    shorter = replace(short_run.result(), scenario="paper-variant", seed=13, frames=8)
    (tmp_path / "last").mkdir()
    run_folder.write(tmp_path / "last", shorter, [], "")
    shutil.rmtree(again)
    with pytest.raises(SystemExit, match="with seed 13 have 10 and 8 frames; run both again"):
        run_script(monkeypatch, tmp_path)
