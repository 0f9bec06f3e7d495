"""Study files of docs/stress-tests.md agree with the code."""

import re
from pathlib import Path

import pytest
from support.paths import DOCS

from luxloop.scenarios.files.scenario import schema_text
from luxloop.scenarios.run import device
from luxloop.scenarios.study import row_store
from luxloop.scenarios.study.design import runs
from luxloop.scenarios.study.row_store import FIXED_COLUMNS
from luxloop.scenarios.study.study_file import Study
from luxloop.scenarios.study.study_page import REPORT

SCENARIO_PAGE = DOCS / "scenario-files.md"
"""Page of the tables that scenario and study files share."""
TEXT = (DOCS / "stress-tests.md").read_text(encoding="utf-8")


def test_every_table_of_keys_has_its_place():
    schema = Study.model_json_schema()
    documented = re.findall(r"<!-- keys of (\w+) -->", TEXT)
    linked = {"OwnMetric"} & set(re.findall(r"<!-- keys of (\w+) -->", SCENARIO_PAGE.read_text(encoding="utf-8")))
    assert sorted([*documented, *linked]) == sorted(["Study", *schema["$defs"]]), "add a marker for the new table"


def test_the_committed_schema_is_current():
    """If this fails: `luxloop schema --study > scenarios/schema/study.schema.json`."""
    assert (DOCS.parent / "scenarios" / "schema" / "study.schema.json").read_text() == schema_text(Study)


@pytest.mark.slow
def test_the_example_has_the_stated_number_of_runs(tmp_path: Path):
    path = tmp_path / "study.toml"
    path.write_text(re.search(r"```toml\n(.*?)```", TEXT, re.DOTALL)[1])
    found = runs(Study.load(path), device.SHIPPED)
    assert f"{len(found)} runs" in TEXT
    last = found[-1].document
    assert last["noise"] == {"attitude": {"enabled": False}, "dropout": {"random_rate": 0.5}}
    assert last["traffic"]["actor"][1]["motion"][0]["speed_mps"] == 24.0


def test_the_page_names_every_file_and_column():
    for name in (row_store.TABLE, row_store.ROWS, REPORT, *FIXED_COLUMNS):
        assert f"`{name}`" in TEXT, name
