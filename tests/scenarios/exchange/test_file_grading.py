"""Gradings of files are results like those of runs: filters, intervals, folder, page and comparison."""

import json

import pytest
from support import box_files

from luxloop.scenarios.cli import main
from luxloop.scenarios.run import run_folder


def drive_of_two_classes():
    """Return cars and trucks, about the ego, whose tracks miss the first truck."""
    truth, tracks = box_files.drive(0)
    truth = [b._replace(kind="truck" if b.id in "34" else "car") for b in truth]
    return truth, [b for b in tracks if b.id != "3"]


def write(folder, truth, tracks):
    about_ego = [box_files.csv(boxes).replace("x_m,y_m,heading_rad", "x_ego_m,y_ego_m,heading_ego_rad")
                 for boxes in (truth, tracks)]  # fmt: skip
    names = ("a.csv", f"tracks-of-{len(tracks)}.csv")
    return [str(box_files.write(folder, name, text)) for name, text in zip(names, about_ego, strict=True)]


@pytest.fixture
def graded(tmp_path, capsys):
    """Folder of a grading, and its JSON document."""
    a, b = write(tmp_path, *drive_of_two_classes())
    assert main(["grade", "--truth", a, "--tracks", b, "--json", "--out", str(tmp_path / "out")]) == 0
    return tmp_path / "out", json.loads(capsys.readouterr().out)


def test_metrics_have_classes_ranges_and_intervals(graded):
    metrics = graded[1]["metrics"]
    truth, _ = drive_of_two_classes()
    trucks = [b for b in truth if b.kind == "truck"]
    assert metrics["track.missed_share{class=truck}"]["n"] == len(trucks)
    assert metrics["track.missed_share{class=truck}"]["value"] > metrics["track.missed_share{class=car}"]["value"]
    near = [b for b in truth if (b.x**2 + b.y**2) ** 0.5 < 15.0]
    assert metrics["track.missed_share{range=0-15}"]["n"] == len(near)
    low, high = metrics["track.hota"]["interval"]
    assert low < metrics["track.hota"]["value"] < high


def test_the_folder_has_the_same_metrics_and_any_other_filter(graded):
    out, document = graded
    found = run_folder.read(out)
    for name, metric in document["metrics"].items():
        if "{" not in name:
            assert (found.metrics[name].value, found.metrics[name].n) == (metric["value"], metric["n"]), name
    assert found.metrics["track.missed_share{range=15-30,class=car}"].n > 0
    assert found.metrics["track.missed_share{view=side}"].reason == "visible sides are not known in files of boxes"
    assert found.metrics["fit.iou_mean"].reason == "files of boxes have only truth and tracks"


def test_the_page_begins_with_the_answer_and_has_figures_by_class_and_range(graded, capsys):
    out, document = graded
    assert main(["report", str(out)]) == 0
    page = out.with_name("out.html").read_text(encoding="utf-8")
    missed = document["metrics"]["track.missed_share"]["value"]
    assert f"The tracks miss {missed:.1%} of {document['true_boxes']} true boxes" in page
    assert page.count("<svg") == 2
    assert "class truck" in page
    assert "range 0-15 m" in page
    capsys.readouterr()


def test_two_trackers_are_compared_against_the_same_truth(graded, capsys):
    out, head = graded[0], graded[0].with_name("head")
    truth, _ = drive_of_two_classes()
    a, b = write(out.parent, truth, box_files.drive(0)[1])
    assert main(["grade", "--truth", a, "--tracks", b, "--out", str(head), "--json"]) == 0
    capsys.readouterr()
    assert main(["compare", str(out), str(head), "--json"]) in (0, 5)
    change = json.loads(capsys.readouterr().out)["metrics"]["track.missed_share"]
    assert change["difference"] < 0.0
