"""Figures of the pages: planted faults are found, and what the pages show now is consistent."""

import json

import pytest
from blocks import claims, commands, stamps
from blocks.catalog import BLOCKS
from blocks.page import pages, parts, write
from support.paths import DOCS, ROOT
from support.scripts import load_script

figures = load_script(DOCS / "figures.py")

TABLE = """| stage | HOTA | missed |
|---|---|---|
| none | 0.696 [0.5, 0.8] | 867 |
| **fit** | 0.804 | 629 |"""
CLAIM = "[fit][HOTA] > [none][HOTA] > 0.6"


@pytest.fixture
def page(tmp_path):
    """A page with a block that was made now, and one that is not touched."""
    path = tmp_path / "page.md"
    path.write_text(f"<!-- blame | {CLAIM} -->\n\n<!-- end -->\nProse.\n<!-- stages -->\nold\n<!-- end -->\n")
    write(path, "blame", TABLE, stamps.runs(BLOCKS["blame"].runs))
    return path


def faults(page):
    return list(figures.faults([part for part in parts(page) if part.name == "blame"], {}))


def test_a_block_is_written_with_command_stamp_and_claims_and_others_stay(page):
    made, other = parts(page)
    assert (made.command, made.text, made.claims) == ("luxloop blame sumo-crossing", TABLE, (CLAIM,))
    assert stamps.baseline()["sumo-crossing"].trace_hash in made.stamp
    assert other.text == "old"
    assert page.read_text().endswith("<!-- end -->\nProse.\n<!-- stages -->\nold\n<!-- end -->\n")
    assert faults(page) == []


def test_a_figure_that_was_changed_by_hand_is_found(page):
    page.write_text(page.read_text().replace("629", "628"))
    (fault,) = faults(page)
    assert fault == "page.md: blame: was changed by hand; python docs/figures.py 'blame'"


def test_a_trace_hash_that_is_not_of_the_baseline_is_found(page):
    page.write_text(page.read_text().replace(stamps.baseline()["sumo-crossing"].trace_hash, 32 * "0"))
    (fault,) = faults(page)
    assert "shows runs that are not of sumo-crossing" in fault


def test_a_picture_that_was_changed_is_found(page):
    picture = page.parent / "pictures" / "a.png"
    picture.parent.mkdir()
    picture.write_bytes(b"one")
    write(page, "blame", TABLE + "\n\n![a](pictures/a.png)", stamps.runs(BLOCKS["blame"].runs))
    assert faults(page) == []
    picture.write_bytes(b"two")
    assert ["changed by hand" in fault for fault in faults(page)] == [True]


def test_a_conclusion_that_the_table_contradicts_is_found(page):
    write(page, "blame", TABLE.replace("0.804", "0.604"), stamps.runs(BLOCKS["blame"].runs))
    (fault,) = faults(page)
    assert f"the text says {CLAIM} (0.604, 0.696, 0.6)" in fault


def test_a_block_that_was_made_again_must_be_the_same(page):
    part, _ = parts(page)
    (fault,) = figures.faults([part], {"blame": TABLE.replace("867", "866")})
    assert "is not what luxloop gives today" in fault


def test_a_claim_by_hand():
    table = "| | time [ms] |\n|---|---|\n| 10 vehicles | 4.3 |\n| 100 vehicles | **12.4** |"
    assert list(claims.broken(("[100 vehicles][time [ms]] < 10 * [10 vehicles][time [ms]]",), table)) == []
    (broken,) = claims.broken(("[100 vehicles][time [ms]] < 2 * [10 vehicles][time [ms]]",), table)
    assert broken.endswith("(12.4, 8.6)")


@pytest.mark.parametrize("term", ["[size][HOTA]", "[fit][IDF1]"])
def test_a_claim_on_a_cell_that_no_table_has_is_an_error(term):
    with pytest.raises(KeyError, match="no such cell"):
        claims.value(term, TABLE)


@pytest.fixture
def baseline_run(tmp_path, monkeypatch):
    """A run of `ring` with the trace hash of the baseline, and the commands that are executed."""
    folder, executed = tmp_path / "ring-seed1", []
    folder.mkdir()
    (folder / "result.json").write_text(json.dumps({"trace_hash": stamps.baseline()["ring"].trace_hash}))
    monkeypatch.setattr(commands, "RUNS", tmp_path)
    monkeypatch.setattr(commands, "output", executed.append)
    return folder, executed


def test_a_run_of_the_baseline_is_used_again_but_not_without_the_recording_that_is_needed(baseline_run):
    folder, executed = baseline_run
    assert commands.run("ring") == folder
    assert executed == []
    with pytest.raises(commands.Missing, match="no recording"):
        commands.run("ring", recording=True)
    assert executed == ["luxloop run ring"]
    (folder / "recording.rrd").touch()
    assert commands.run("ring", recording=True) == folder
    assert len(executed) == 1


def test_every_block_of_the_pages_is_consistent():
    """Its name is known, its claims hold, and it is as it was made. `make check` holds it against the baseline."""
    found = [part for path in pages(ROOT) for part in parts(path)]
    assert {part.name for part in found} == BLOCKS.keys()
    assert [fault for fault in figures.faults(found, {}) if "shows runs" not in fault] == []


def test_tables_of_keys_and_scenarios_are_those_of_the_code():
    """If this fails: `python docs/figures.py NAME`."""
    found = [part for path in pages(ROOT) for part in parts(path)]
    for part in found:
        if BLOCKS[part.name].maker.startswith("reference:") and BLOCKS[part.name].maker != "reference:printed":
            assert BLOCKS[part.name].make(part.name) == part.text, part.name
