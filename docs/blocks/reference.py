"""Parts that follow from the code alone: tables of keys and scenarios, and what examples print."""

import json
import subprocess
import sys
from functools import cache
from pathlib import Path
from typing import Any

from blocks import stamps
from blocks.markdown import markdown

from luxloop.scenarios.files import shipped as listing
from luxloop.scenarios.files.expect import cause_of
from luxloop.scenarios.files.scenario import Scenario
from luxloop.scenarios.study.study_file import Study

EXAMPLES = Path(__file__).parents[1] / "examples"
PROGRAMS = {
    "first run": (EXAMPLES / "first_run.py",),
    "output": (EXAMPLES / "track_csv.py", EXAMPLES / "points.csv"),
}
"""Programs with their arguments, by the blocks that show what they print."""
TYPES = {"number": "number", "integer": "whole number", "string": "text", "boolean": "true or false", "array": "list"}
"""Names of JSON types in TOML."""

Json = dict[str, Any]


@cache
def definitions() -> dict[str, Json]:
    """Return the JSON schemas of all tables of scenario and study files, by name."""
    schemas = (Study.model_json_schema(), Scenario.model_json_schema())
    return {name: one for schema in schemas for name, one in {schema["title"]: schema, **schema["$defs"]}.items()}


@cache
def shipped() -> list[Scenario]:
    """Return the scenarios that ship."""
    return [Scenario.load(path) for path in listing.paths().values()]


def scenarios(name: str) -> str:
    """Return the table of `scenarios of FAMILY`: description, reason and expectations."""
    rows = []
    for scenario in (one for one in shipped() if one.folder.name == name.removeprefix("scenarios of ")):
        title = f"`{scenario.name}`" + (" (smoke)" if scenario.suite == "smoke" else "")
        limits = [f"`{metric}` {limit}" for metric, limit in scenario.expect.items()]
        rows.append((title, scenario.description, scenario.reason, "<br>".join(limits)))
    return markdown(("scenario", "what happens", "why", "expected"), rows)


def known_failures(_name: str) -> str:
    """Return the table of the expectations that are known to fail, with the values of the baseline and causes."""
    today = stamps.baseline()
    rows = (
        (
            f"`{scenario.name}`",
            f"`{metric}` {limit}",
            f"{today[scenario.name].expectations[metric].value:.3g}",
            cause_of(limit.known_failure),
        )
        for scenario in shipped()
        for metric, limit in scenario.expect.items()
        if limit.known_failure
    )
    return markdown(("scenario", "expectation", "today", "why it fails"), rows)


def printed(name: str) -> str:
    """Return what an example prints."""
    done = subprocess.run([sys.executable, *PROGRAMS[name]], capture_output=True, text=True, check=True)
    return f"```text\n{done.stdout.strip()}\n```"


def nearest(_name: str) -> str:
    """Return the whole of the tracker that own-tracker.md shows."""
    text = (EXAMPLES / "ci" / "my_tracker.py").read_text(encoding="utf-8")
    return f"```python\n{text}```"


def keys(name: str) -> str:
    """Return the table of keys of `keys of TABLE`."""
    definition = definitions()[name.removeprefix("keys of ")]
    required = definition.get("required", [])
    rows = (
        (f"`{key}`", type_of(field), "required" if key in required else default_of(field), meaning_of(field))
        for key, field in definition["properties"].items()
    )
    return markdown(("key", "type", "default", "meaning"), rows)


def default_of(field: Json) -> str:
    """Return a key's default in TOML syntax; an empty string if the default is absent or empty."""
    default = field.get("default")
    return "" if default in (None, "", [], {}) or isinstance(default, dict) else f"`{json.dumps(default)}`"


def type_of(field: Json) -> str:
    """Return the TOML name of a key's type."""
    if "const" in field:
        return f'`"{field["const"]}"`'
    if "enum" in field:
        return " or ".join(f'`"{choice}"`' for choice in field["enum"])
    if "anyOf" in field:
        return type_of(next(choice for choice in field["anyOf"] if choice.get("type") != "null"))
    return TYPES.get(field.get("type", ""), "table")


def meaning_of(field: Json) -> str:
    """Return a key's description, or else that of the table it contains."""
    text: str = field.get("description", "")
    if not text and "$ref" in field:
        text = definitions()[field["$ref"].rpartition("/")[2]].get("description", "").partition("\n\n")[0]
    return " ".join(text.split()).replace("|", "\\|")
