"""docs/formats.md: its commands run, and its tables of metrics and formats are those of the code."""

import re
import shlex

import pytest
from support.paths import ROOT

from scenarios.cli import main
from scenarios.exchange.box_metric_names import DEFINITIONS
from scenarios.exchange.file_formats import FORMATS

PAGE = (ROOT / "docs" / "formats.md").read_text(encoding="utf-8")
COMMANDS = [
    shlex.split(line)
    for block in re.findall(r"^```sh\n(.*?)^```", PAGE, re.DOTALL | re.MULTILINE)
    for line in block.splitlines()
]


def test_every_command_runs(tmp_path, monkeypatch, capsys):
    """In one folder and in order: the exports are graded."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "docs").symlink_to(ROOT / "docs")
    printed = {}
    for program, *words in COMMANDS:
        assert program == "luxloop"
        assert main(words) == 0, words
        printed[shlex.join(words)] = capsys.readouterr().out
    verbs = [words[1] for words in COMMANDS]
    assert (verbs.count("grade"), verbs.count("export"), verbs.count("mcap")) == (6, 4, 1)
    first = next(iter(printed.values()))
    assert re.search(r"^track\.gospa_m +12\.450 ", first, re.MULTILINE)
    paths = re.findall(r"^\| `((?:training|results|samples|v1\.0|maps|tracking)[\w./*-]+)` \|", PAGE, re.MULTILINE)
    assert len(paths) == 10
    for path in paths:
        folder = tmp_path / ("kitti" if path.startswith(("training", "results")) else "scene")
        assert list(folder.glob(path)), path


def test_every_metric_is_listed_with_its_unit():
    rows = re.findall(r"^\| `(track\.\w+)` \| ([\w/^]+) \|", PAGE, re.MULTILINE)
    assert rows == [(name, definition.unit) for name, definition in DEFINITIONS.items()]


@pytest.mark.parametrize("name", FORMATS)
def test_every_format_is_listed(name):
    table = PAGE.partition("| format |")[2].partition("\n\n")[0]
    assert f"`{name}`" in table
