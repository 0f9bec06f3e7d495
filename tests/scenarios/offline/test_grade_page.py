"""docs/own-tracker.md: its commands run, and its columns and figures agree with the code."""

import json
import re
import shlex
import subprocess
import sys
from pathlib import Path

import pytest
from support.optional import need
from support.pages import block
from support.paths import DOCS, ROOT

from luxloop.scenarios.cli import main
from luxloop.scenarios.offline.track_file import OPTIONAL, REQUIRED, WHEN

PAGE = (DOCS / "own-tracker.md").read_text(encoding="utf-8").partition("\n## The league\n")[0]
COMMANDS = [
    shlex.split(line)
    for block in re.findall(r"^```sh\n(.*?)^```", PAGE, re.DOTALL | re.MULTILINE)
    for line in block.splitlines()
    if "process:" not in line
    and not line.startswith("g++")  # need a compiler: tests/scenarios/run/test_process_tracker.py
]


@pytest.fixture(scope="module")
def outputs(tmp_path_factory):
    """Metrics of runs and gradings, or the exit code, of every command of the page, in order."""
    folder, found = tmp_path_factory.mktemp("clone"), {}
    (folder / "docs").symlink_to(ROOT / "docs")
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        patch.syspath_prepend(folder)
        for program, *rest in COMMANDS:
            line = shlex.join(rest)
            if program == "python":
                command = [sys.executable, "-W", "error", *rest]
                found[line] = subprocess.run(command, capture_output=True, text=True, check=False).returncode
            else:
                out = [] if "--out" in rest or rest[0] != "grade" else ["--out", f"graded{len(found)}"]
                found[line] = main([*rest, *out])
                if rest[0] in ("run", "grade"):
                    place = Path([*rest, *out][[*rest, *out].index("--out") + 1])
                    found[line] = found[line] or json.loads((place / "result.json").read_text())["metrics"]
    return found


@pytest.mark.slow
def test_every_command_runs(outputs):
    """Gradings and runs return their metrics, the others exit with 0."""
    need("mcap")
    assert {COMMANDS[0][0], "python"} == {program for program, *_ in COMMANDS}
    assert all(found == 0 or isinstance(found, dict) for found in outputs.values()), outputs
    assert {words.split()[0] for words in outputs} >= {"run", "grade", "check-tracker", "mcap"}


@pytest.mark.slow
def test_the_table_agrees_with_all_three_ways_of_grading(outputs):
    """In the loop, on the recorded scans, and from a file."""
    shipped = [found for line, found in outputs.items() if "--record-scans" in line or line == "grade recorded"]
    patch = [
        found
        for line, found in outputs.items()
        if isinstance(found, dict) and ("PatchTracker" in line or "--tracks" in line)
    ]
    assert (len(shipped), len(patch)) == (2, 3)
    rows = re.findall(
        r"^\| `(track\.\w+)` \| ([\d.]+) \| ([\d.]+) \|", block(DOCS / "own-tracker.md", "trackers"), re.MULTILINE
    )
    assert len(rows) == 7
    for name, *shown in rows:
        for figure, documents in zip(shown, (shipped, patch), strict=True):
            for metrics in documents:
                assert metrics[name]["value"] == pytest.approx(float(figure), rel=0.02, abs=0.01), name


def test_the_layout_is_documented_column_by_column():
    table = re.findall(r"^\| `(\w+)` \| (\w*) ?\| (.*) \|$", PAGE, re.MULTILINE)
    documented = {name: (unit, meaning) for name, unit, meaning in table}
    columns = (*WHEN, *REQUIRED, *OPTIONAL)
    assert [name for name, _, _ in table if name in {column.name for column in columns}] == [c.name for c in columns]
    for column in (*WHEN, *REQUIRED):
        assert documented[column.name] == (column.unit, column.meaning)
    assert all(f"`{name}`" in documented["status"][1] for name in OPTIONAL[0].kind)
