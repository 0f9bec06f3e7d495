"""Writes into the documentation what the code and a real run say. Tests fail where that is out of date.

    python docs/refresh.py                             # tables of keys, and the output of the library's example
    luxloop run sumo-crossing
    python docs/refresh.py runs/sumo-crossing-seed1    # also the report in README.md

What it writes stands between `<!-- keys of NAME -->`, `<!-- output -->` or `<!-- report -->` and `<!-- end -->`.
"""

import json
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

from scenarios import run_folder
from scenarios.scenario import Scenario

DOCS = Path(__file__).parent
README = DOCS.parent / "README.md"
SCENARIO_FILES = DOCS / "scenario-files.md"
LIBRARY = DOCS / "library.md"
EXAMPLE = (DOCS / "examples" / "track_csv.py", DOCS / "examples" / "points.csv")
"""What `LIBRARY` shows the output of."""

SHOWN = ("Heading error by method", "Tracking", "Time per frame", "PASSED", "FAILED")
"""Beginnings of the sections of a report that the README shows after the first, which tells what was run."""

TYPES = {"number": "number", "integer": "whole number", "string": "text", "boolean": "true or false", "array": "list"}
"""TOML's words for JSON's."""

Json = dict[str, Any]


def main() -> None:
    """Refresh the tables of keys and the example's output, and with a run folder the report."""
    text = SCENARIO_FILES.read_text(encoding="utf-8")
    SCENARIO_FILES.write_text(with_keys(text, Scenario.model_json_schema()), encoding="utf-8")
    output = subprocess.run([sys.executable, *EXAMPLE], capture_output=True, text=True, check=True).stdout
    LIBRARY.write_text(with_text(LIBRARY.read_text(encoding="utf-8"), "output", output.strip()), encoding="utf-8")
    if len(sys.argv) > 1:
        report = (Path(sys.argv[1]) / run_folder.REPORT).read_text(encoding="utf-8")
        shown = with_text(README.read_text(encoding="utf-8"), "report", excerpt(report))
        README.write_text(shown, encoding="utf-8")


def with_keys(text: str, schema: Json) -> str:
    """Return a page with every table of keys written anew from the JSON schema."""
    definitions = {"Scenario": schema, **schema["$defs"]}
    return re.sub(
        r"(<!-- keys of (\w+) -->\n).*?(<!-- end -->)",
        lambda match: match[1] + key_table(definitions[match[2]], definitions) + match[3],
        text,
        flags=re.DOTALL,
    )


def with_text(page: str, name: str, text: str) -> str:
    """Return a page with the block `name` written anew."""
    start, _, rest = page.partition(f"<!-- {name} -->\n")
    _, _, after = rest.partition("<!-- end -->")
    return f"{start}<!-- {name} -->\n```text\n{text}\n```\n<!-- end -->{after}"


def excerpt(report: str) -> str:
    """Return the sections of a report that the README shows, `[...]` where others are left out."""
    lines = "\n".join(line.rstrip() for line in report.splitlines())
    header, *sections = re.split(r"\n\n+(?!whole loop)", lines.strip())
    shown = [header]
    for section in sections:
        if section.startswith(SHOWN):
            shown.append(section)
        elif shown[-1] != "[...]":
            shown.append("[...]")
    return "\n\n".join(shown)


def key_table(definition: Json, definitions: Json) -> str:
    """Return the keys of one table of a scenario file as Markdown."""
    required = definition.get("required", [])
    rows = ["| key | type | default | meaning |", "|---|---|---|---|"]
    for key, field in definition["properties"].items():
        default = "required" if key in required else default_of(field)
        rows.append(f"| `{key}` | {type_of(field)} | {default} | {meaning_of(field, definitions)} |")
    return "\n".join(rows) + "\n"


def default_of(field: Json) -> str:
    """Return a key's default as it would stand in TOML; nothing for what is absent or empty by default."""
    default = field.get("default")
    return "" if default in (None, "", [], {}) or isinstance(default, dict) else f"`{json.dumps(default)}`"


def type_of(field: Json) -> str:
    """Return a key's type in TOML's words."""
    if "const" in field:
        return f'`"{field["const"]}"`'
    if "enum" in field:
        return " or ".join(f'`"{choice}"`' for choice in field["enum"])
    if "anyOf" in field:
        return type_of(next(choice for choice in field["anyOf"] if choice.get("type") != "null"))
    return TYPES.get(field.get("type", ""), "table")


def meaning_of(field: Json, definitions: Json) -> str:
    """Return a key's description, else that of the table it holds."""
    text: str = field.get("description", "")
    if not text and "$ref" in field:
        text = definitions[field["$ref"].rpartition("/")[2]].get("description", "").partition("\n\n")[0]
    return " ".join(text.split()).replace("|", "\\|")


if __name__ == "__main__":
    main()
