"""Figures and tables as files: `luxloop report --figures --latex`, `luxloop paper`."""

import re

import pytest
from support import short_run

from luxloop.scenarios.cli import main
from luxloop.scenarios.document.figure import Figure, parse_formats
from luxloop.scenarios.errors import InputError
from luxloop.scenarios.execute import execute
from luxloop.scenarios.files.scenario import Scenario
from luxloop.scenarios.run import device, run_folder


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    folder = tmp_path_factory.mktemp("run")
    scenario = Scenario.load(short_run.write(folder))
    execute(scenario, device.load(device.SHIPPED), folder / "short", record=False)
    return folder / "short"


def paint(canvas):
    canvas.subplots().plot([0, 1], [0, 1], label="a line")


def test_formats_are_those_asked_for_and_equal_figures_give_equal_files(tmp_path):
    figure = Figure("a", "A title", "", (3.0, 2.0), paint)
    (tmp_path / "again").mkdir()
    paths = figure.save(tmp_path, ["png", "svg", "pdf"])
    assert [path.name for path in paths] == ["a.png", "a.svg", "a.pdf"]
    assert [path.read_bytes()[:5] for path in paths] == [b"\x89PNG\r", b"<?xml", b"%PDF-"]
    assert ">A title</text>" in paths[1].read_text(encoding="utf-8")
    for before, after in zip(paths, figure.save(tmp_path / "again", ["png", "svg", "pdf"]), strict=True):
        assert before.read_bytes() == after.read_bytes()


def test_formats_of_the_option():
    assert parse_formats(None) == []
    assert parse_formats("svg, pdf,svg") == ["svg", "pdf"]
    for text in ("eps", "svg,", ""):
        with pytest.raises(InputError, match=r"is no format; give some of png, svg, pdf"):
            parse_formats(text)


@pytest.mark.slow
def test_report_writes_every_figure_of_the_page_and_all_tables(run, tmp_path, capfd):
    page = tmp_path / "page.html"
    assert main(["report", str(run), "--out", str(page), "--figures", "pdf", "--latex"]) == 0
    names = re.findall(r'<figure id="([^"]+)"', page.read_text(encoding="utf-8"))
    written = sorted(path.name for path in (tmp_path / "page-figures").iterdir())
    assert written == sorted(f"{name}.pdf" for name in names)
    assert f"{len(written)} figures are in {tmp_path / 'page-figures'}" in capfd.readouterr().out
    assert r"\caption{Tracking}" in (tmp_path / "page-tables.tex").read_text(encoding="utf-8")


def test_files_of_many_runs_are_refused(run, capfd):
    assert main(["report", str(run.parent), "--figures", "svg"]) == 2
    assert "--figures and --latex need the folder of a single run" in capfd.readouterr().err
    assert main(["report", str(run), "--figures", "bmp"]) == 2
    assert "--figures bmp: bmp is no format" in capfd.readouterr().err


def test_paper_prints_one_table_or_all(run, capfd):
    titles = [f"Table {number}:" for number in ("I", "II", "III", "IV")]
    for number, title in enumerate(titles, start=1):
        assert main(["paper", str(run), "--table", str(number)]) == 0
        out = capfd.readouterr().out
        assert [other in out for other in titles] == [other == title for other in titles]
    assert main(["paper", str(run)]) == 0
    out = capfd.readouterr().out
    assert all(title in out for title in titles)
    value = run_folder.read(run).metrics["fit.heading_abs_mean_deg"].value
    assert re.search(rf"^mean \|e\|, best +1.352 +{value:.3f} *$", out, re.MULTILINE)
    assert out.startswith(f"Not reproduced: with {run}, best selection errs by")
    assert main(["paper", str(run), "--table", "3", "--latex"]) == 0
    assert capfd.readouterr().out.count(r"\begin{tabular}") == 1


def test_paper_without_a_folder_takes_the_runs_of_its_scenario(run, tmp_path, monkeypatch, capfd):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "runs").mkdir()
    for name in ("paper-campus-seed1", "paper-campus-seed1-paper"):
        (tmp_path / "runs" / name).symlink_to(run)
    assert main(["paper", "--table", "1"]) == 0
    out = capfd.readouterr().out
    assert re.search(r"^category +paper +the paper's steps +default$", out, re.MULTILINE)
    assert main(["paper", "--table", "5"]) == 2
