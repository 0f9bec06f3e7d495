"""docs/formats.md: its commands run, and its tables of formats are those of the code."""

import re
import shlex

import pytest
from support.optional import need

need("osi")

from mcap.reader import make_reader
from support.paths import ROOT

from luxloop.plugins import formats_that
from luxloop.scenarios.cli import main
from luxloop.scenarios.offline.recorded_scans import RecordedRun

FORMATS, EXPORTS = formats_that("read_boxes"), formats_that("export")
PAGE = (ROOT / "docs" / "formats.md").read_text(encoding="utf-8")
FOLDERS = {"KITTI": "kitti", "nuScenes": "scene", "T4": "t4", "LUX": "lux"}
"""Sections with a table of paths, and the folders of their exports on the page."""
COMMANDS = [
    shlex.split(line)
    for block in re.findall(r"^```sh\n(.*?)^```", PAGE, re.DOTALL | re.MULTILINE)
    for line in block.splitlines()
]


@pytest.mark.slow
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
    assert (verbs.count("grade"), verbs.count("export"), verbs.count("mcap")) == (8, 5, 1)
    first = next(iter(printed.values()))
    assert re.search(r"^track\.gospa_m +12\.450 ", first, re.MULTILINE)
    for title, folder in FOLDERS.items():
        rows = re.findall(r"^\| `([^`]+)` \|", section(title), re.MULTILINE)
        assert len(set(rows)) > 1, title
        for path in rows:
            assert list((tmp_path / folder).glob(path.replace("UNIT", "*"))), path
    topics = set(re.findall(r"^\| `([^`]+)` \|", section("ASAM OSI"), re.MULTILINE))
    units = {mount.name for mount in RecordedRun.open(tmp_path / "recorded").rig.mounts}
    with (tmp_path / "osi" / "trace.mcap").open("rb") as stream:
        written = {channel.topic for channel in make_reader(stream).get_summary().channels.values()}
    assert written == {topic.replace("UNIT", unit) for topic in topics for unit in units}


def section(title):
    return PAGE.partition(f"### {title}\n")[2].partition("\n##")[0]


@pytest.mark.parametrize("name", FORMATS)
def test_every_format_is_listed(name):
    table = PAGE.partition("| format |")[2].partition("\n\n")[0]
    assert f"`{name}`" in table


def test_every_export_is_described():
    used = {words[words.index("--format") + 1] for words in COMMANDS if words[1] == "export"}
    assert used == set(EXPORTS)
    assert {name for name in EXPORTS if f"`luxloop export RUN --format {name}`" in PAGE} == set(EXPORTS)
