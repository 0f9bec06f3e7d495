"""The page on study files says what the code does."""

import importlib.util
import re
from pathlib import Path

from scenarios import device
from scenarios.study import rows
from scenarios.study.design import runs
from scenarios.study.study import Study
from scenarios.study.task import FIXED_COLUMNS

DOCS = Path(__file__).parents[1] / "docs"
TEXT = (DOCS / "study-files.md").read_text(encoding="utf-8")

_spec = importlib.util.spec_from_file_location("refresh", DOCS / "refresh.py")
refresh = importlib.util.module_from_spec(_spec)
_spec.loader.exec_module(refresh)


def with_keys(text: str) -> str:
    """The page with its tables as the code has them."""
    schema = Study.model_json_schema()
    return refresh.with_keys(text, {**schema, "$defs": {**schema["$defs"], "Study": schema}})


def test_the_tables_of_keys_are_those_of_the_code():
    assert with_keys(TEXT) == TEXT
    assert re.findall(r"<!-- keys of (\w+) -->", TEXT) == ["Study", "Vary", "Curve"]


def test_the_example_is_as_many_runs_as_it_says(tmp_path: Path):
    path = tmp_path / "study.toml"
    path.write_text(re.search(r"```toml\n(.*?)```", TEXT, re.DOTALL)[1])
    found = runs(Study.load(path), device.SHIPPED)
    assert f"{len(found)} runs" in TEXT
    last = found[-1].document
    assert last["noise"] == {"dropout": {"random_rate": 0.5}}
    assert last["traffic"]["actor"][1]["motion"][0]["speed_mps"] == 24.0


def test_the_page_names_every_file_and_column():
    for name in (rows.RUNS, rows.EARLIER, rows.JOURNAL, *FIXED_COLUMNS):
        assert f"`{name}`" in TEXT, name
