"""Write generated tables and quoted reports into the documentation. Tests fail where a page is out of date.

    python docs/refresh.py                             # tables of keys and scenarios, output of Python examples
    luxloop run sumo-crossing
    python docs/refresh.py runs/sumo-crossing-seed1    # also the first screen in README.md and docs/getting-started.md

Generated text is between `<!-- keys of NAME -->`, `<!-- scenarios of FAMILY -->`, `<!-- known failures -->`,
`<!-- output -->`, `<!-- first run -->` or `<!-- report -->` and `<!-- end -->`. `docs/paper_tables.py` writes the
paper's tables.
"""

import json
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

from luxloop.scenarios.files import shipped as listing
from luxloop.scenarios.files.scenario import Scenario
from luxloop.scenarios.report import first_screen
from luxloop.scenarios.report.html.reported_run import ReportedRun
from luxloop.scenarios.run import run_folder
from luxloop.scenarios.study.study_file import Study

DOCS = Path(__file__).parent
SCENARIO_FILES = DOCS / "scenario-files.md"
STUDY_PAGES = (DOCS / "study-files.md", DOCS / "search.md")
PYTHON = DOCS / "python.md"
CATALOG = DOCS / "catalog.md"
EXAMPLES = {
    "first run": (DOCS / "examples" / "first_run.py",),
    "output": (DOCS / "examples" / "track_csv.py", DOCS / "examples" / "points.csv"),
}
"""Programs with their arguments, by the blocks of `PYTHON` that show their output."""


REPORTED = "sumo-crossing"
"""Scenario whose first screen the pages show."""
REPORT_PAGES = (DOCS.parent / "README.md", DOCS / "getting-started.md")
COLUMNS = 80
"""Width of the screen on these pages."""

TYPES = {"number": "number", "integer": "whole number", "string": "text", "boolean": "true or false", "array": "list"}
"""Names of JSON types in TOML."""

Json = dict[str, Any]


def main() -> None:
    """Refresh generated tables and the example's output, and the reports of the run folders given as arguments."""
    text = SCENARIO_FILES.read_text(encoding="utf-8")
    SCENARIO_FILES.write_text(with_keys(text, Scenario.model_json_schema()), encoding="utf-8")
    for page in STUDY_PAGES:
        page.write_text(with_keys(page.read_text(encoding="utf-8"), Study.model_json_schema()), encoding="utf-8")
    CATALOG.write_text(with_scenarios(CATALOG.read_text(encoding="utf-8")), encoding="utf-8")
    for block, example in EXAMPLES.items():
        output = subprocess.run([sys.executable, *example], capture_output=True, text=True, check=True).stdout
        PYTHON.write_text(with_text(PYTHON.read_text(encoding="utf-8"), block, output.strip()), encoding="utf-8")
    for run in sys.argv[1:]:
        quote(Path(run))


def quote(folder: Path) -> None:
    """Write the first screen of a run into the pages that show it."""
    run = ReportedRun.read(folder)
    if run.result.scenario != REPORTED:
        sys.exit(f"{folder}: no page shows a report of {run.result.scenario}; give a run of {REPORTED}")
    for page in REPORT_PAGES:
        page.write_text(with_text(page.read_text(encoding="utf-8"), "report", screen(run)), encoding="utf-8")


def screen(run: ReportedRun) -> str:
    """Return what `luxloop run` printed for a run in its default folder."""
    folder = Path("runs") / f"{run.result.scenario}-seed{run.result.seed}"
    commands = first_screen.commands_of(folder, recorded=True)
    lines = first_screen.screen(run.result, run.checks, commands, str(folder / run_folder.REPORT), COLUMNS)
    return "\n".join(line.plain for line in lines)


def with_keys(text: str, schema: Json) -> str:
    """Return a page with every table of keys replaced by that of the JSON schema."""
    definitions = {schema["title"]: schema, **schema["$defs"]}
    return re.sub(
        r"(<!-- keys of (\w+) -->\n).*?(<!-- end -->)",
        lambda match: match[1] + key_table(definitions[match[2]], definitions) + match[3],
        text,
        flags=re.DOTALL,
    )


def with_scenarios(text: str) -> str:
    """Return the page of the catalog with its tables replaced by those of the scenario files."""
    shipped = [Scenario.load(path) for path in listing.paths().values()]
    text = re.sub(
        r"(<!-- scenarios of (\w+) -->\n).*?(<!-- end -->)",
        lambda match: match[1] + scenario_table([s for s in shipped if s.folder.name == match[2]]) + match[3],
        text,
        flags=re.DOTALL,
    )
    failures = re.compile(r"(<!-- known failures -->\n).*?(<!-- end -->)", re.DOTALL)
    return failures.sub(lambda match: match[1] + failure_table(shipped) + match[2], text)


def scenario_table(scenarios: list[Scenario]) -> str:
    """Return description, reason and expectations of scenarios as a Markdown table."""
    rows = ["| scenario | what happens | why | expected |", "|---|---|---|---|"]
    for scenario in scenarios:
        name = f"`{scenario.name}`" + (" (smoke)" if scenario.suite == "smoke" else "")
        limits = [f"`{metric}` {limit}" for metric, limit in scenario.expect.items()]
        rows.append(f"| {name} | {scenario.description} | {scenario.reason} | {'<br>'.join(limits)} |")
    return "\n".join(rows) + "\n"


def failure_table(scenarios: list[Scenario]) -> str:
    """Return the expectations that are known to fail, with causes, as a Markdown table."""
    rows = ["| scenario | expectation | why it fails |", "|---|---|---|"]
    rows += [
        f"| `{scenario.name}` | `{metric}` {limit} | {limit.known_failure} |"
        for scenario in scenarios
        for metric, limit in scenario.expect.items()
        if limit.known_failure
    ]
    return "\n".join(rows) + "\n"


def with_text(page: str, name: str, text: str) -> str:
    """Return a page with the content of block `name` replaced."""
    start, _, rest = page.partition(f"<!-- {name} -->\n")
    _, _, after = rest.partition("<!-- end -->")
    return f"{start}<!-- {name} -->\n```text\n{text}\n```\n<!-- end -->{after}"


def key_table(definition: Json, definitions: Json) -> str:
    """Return the keys of one table of a scenario file as Markdown."""
    required = definition.get("required", [])
    rows = ["| key | type | default | meaning |", "|---|---|---|---|"]
    for key, field in definition["properties"].items():
        default = "required" if key in required else default_of(field)
        rows.append(f"| `{key}` | {type_of(field)} | {default} | {meaning_of(field, definitions)} |")
    return "\n".join(rows) + "\n"


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


def meaning_of(field: Json, definitions: Json) -> str:
    """Return a key's description, or else that of the table it contains."""
    text: str = field.get("description", "")
    if not text and "$ref" in field:
        text = definitions[field["$ref"].rpartition("/")[2]].get("description", "").partition("\n\n")[0]
    return " ".join(text.split()).replace("|", "\\|")


if __name__ == "__main__":
    main()
