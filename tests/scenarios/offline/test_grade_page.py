"""The page on other trackers: its commands run, its columns are those of the layout, its figures are what comes out."""

import json
import re
import shlex
import subprocess
import sys
from pathlib import Path

import pytest
from support.paths import ROOT

from scenarios.cli import main
from scenarios.offline.track_columns import OPTIONAL, REQUIRED, WHEN

PAGE = (ROOT / "docs" / "other-trackers.md").read_text(encoding="utf-8")
COMMANDS = [
    shlex.split(line)
    for block in re.findall(r"^```sh\n(.*?)^```", PAGE, re.DOTALL | re.MULTILINE)
    for line in block.splitlines()
]


@pytest.fixture(scope="module")
def typed(tmp_path_factory):
    """A folder in which somebody has typed every command of the page; what gradings and runs said, in order."""
    folder, said = tmp_path_factory.mktemp("clone"), {}
    (folder / "docs").symlink_to(ROOT / "docs")
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        patch.syspath_prepend(folder)
        for program, *rest in COMMANDS:
            line = shlex.join(rest)
            if program == "python":
                command = [sys.executable, "-W", "error", *rest]
                said[line] = subprocess.run(command, capture_output=True, text=True, check=False).returncode
            else:
                out = [] if "--out" in rest or rest[0] != "grade" else ["--out", f"graded{len(said)}"]
                said[line] = main([*rest, *out])
                if rest[0] in ("run", "grade"):
                    place = Path([*rest, *out][[*rest, *out].index("--out") + 1])
                    said[line] = said[line] or json.loads((place / "result.json").read_text())["metrics"]
    return said


def test_every_command_runs(typed):
    """Gradings and runs leave their metrics, the others exit with 0."""
    assert {COMMANDS[0][0], "python"} == {program for program, *_ in COMMANDS}
    assert all(said == 0 or isinstance(said, dict) for said in typed.values()), typed
    assert {words.split()[0] for words in typed} >= {"run", "grade", "check-tracker", "mcap"}


def test_the_two_columns_are_what_comes_out_in_every_way(typed):
    """Once in the loop, once over the recorded scans, once through a file."""
    shipped = [said for line, said in typed.items() if "--record-scans" in line or line == "grade recorded"]
    patch = [
        said
        for line, said in typed.items()
        if isinstance(said, dict) and ("PatchTracker" in line or "--tracks" in line)
    ]
    assert (len(shipped), len(patch)) == (2, 3)
    rows = re.findall(r"^\| `(track\.\w+)` \| ([\d.]+) \| ([\d.]+) \|", PAGE, re.MULTILINE)
    assert len(rows) == 7
    for name, *shown in rows:
        for figure, documents in zip(shown, (shipped, patch), strict=True):
            for metrics in documents:
                assert metrics[name]["value"] == pytest.approx(float(figure), rel=0.02, abs=0.01), name


def test_the_layout_is_told_column_by_column():
    table = re.findall(r"^\| `(\w+)` \| (\w*) ?\| (.*) \|$", PAGE, re.MULTILINE)
    told = {name: (unit, meaning) for name, unit, meaning in table}
    columns = (*WHEN, *REQUIRED, *OPTIONAL)
    assert [name for name, _, _ in table if name in {column.name for column in columns}] == [c.name for c in columns]
    for column in (*WHEN, *REQUIRED):
        assert told[column.name] == (column.unit, column.meaning)
    assert all(f"`{name}`" in told["status"][1] for name in OPTIONAL[0].kind)
