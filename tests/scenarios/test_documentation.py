"""The documentation: its commands run, its examples work, and it lists every key, metric, column and command."""

import ast
import inspect
import re
import shlex
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest
from support.optional import need

need("search")

import tomli_w
import typer
from blocks import screens
from support import short_run
from support.dask_cluster import worker_thread
from support.pages import block, chapter
from support.paths import DOCS, ROOT
from support.scripts import load_script

import luxloop
from luxloop.scenarios.cli import app, main
from luxloop.scenarios.control import ego_driver
from luxloop.scenarios.files import shipped as listing
from luxloop.scenarios.files.scenario import Scenario
from luxloop.scenarios.grading import emergence, frame_tables, occlusions
from luxloop.scenarios.grading.truth_events import truth_event
from luxloop.scenarios.metrics.definition import FILTERS
from luxloop.scenarios.metrics.definitions import (
    CLASSES,
    CORNER_FIGURES,
    COVERAGES,
    DEFINITIONS,
    DRIVERS,
    GROUPS,
    HORIZONS,
    NO_VIEW,
    REQUIRED,
    TIMED_STAGES,
    VIEWS,
    WITHIN_DEG,
)
from luxloop.scenarios.metrics.former_names import FORMER, present_name
from luxloop.scenarios.metrics.main_figures import ON_FIRST_SCREEN
from luxloop.scenarios.report import first_screen
from luxloop.scenarios.report.html.reported_run import ReportedRun
from luxloop.scenarios.run import run_folder

README, KEYS, RESULTS = ROOT / "README.md", ROOT / "docs" / "scenario-files.md", ROOT / "docs" / "results.md"
INDEX, TRACKER, PAPER, COMMANDS = (
    ROOT / "docs" / f"{name}.md" for name in ("index", "tracker", "paper", "command-line")
)
STRESS = "stress-tests.md"
PAGES = [README, ROOT / "CONTRIBUTING.md", ROOT / "CHANGELOG.md", *sorted((ROOT / "docs").glob("*.md"))]
EXAMPLES = {README: "braking-car.toml", INDEX: "my-first.toml"}
"""The scenario file that a page shows as a whole."""
VARIANT = ROOT / "docs" / "examples" / "paper-variant.toml"
SHORT_S = "1"
"""Simulated time of shipped scenarios here [s]."""
ABSENT = (
    *("luxloop.sim", "luxloop.sensor_model", "luxloop.scenarios", "libsumo", "highway_env", "gymnasium", "rerun"),
    *("pandas", "pyarrow", "pydantic", "typer", "rich", "shapely", "matplotlib"),
)
"""Packages that the tracker alone must not need."""
MADE_LATER = {"benchmarks/latest.json"}

each_page = pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)


def blocks(page: Path, *languages: str) -> list[str]:
    """Fenced blocks of a page."""
    found = re.findall(r"^```(\w+)\n(.*?)^```", page.read_text(encoding="utf-8"), flags=re.DOTALL | re.MULTILINE)
    return [text for language, text in found if language in languages]


def commands(page: Path) -> list[list[str]]:
    lines = "".join(blocks(page, "console", "sh")).splitlines()
    return [shlex.split(line, comments=True) for line in lines]


def section(page: Path, title: str) -> str:
    return re.search(rf"^#+ {title}\n(.*?)(?=^#|\Z)", page.read_text(encoding="utf-8"), re.DOTALL | re.MULTILINE)[1]


def section_tree(page: Path, title: str) -> str:
    """A second-level section with its subsections."""
    return re.search(rf"^## {title}\n(.*?)(?=^## |\Z)", page.read_text(encoding="utf-8"), re.DOTALL | re.MULTILINE)[1]


def follow(command: list[str]) -> int:
    """Execute a `luxloop` command, with shipped scenarios shortened. `view` only checks that a recording exists.

    `paper` prints the tables of a short run, because the runs of its own scenario take minutes.
    """
    _, verb, *rest = command
    if verb == "sweep":
        with worker_thread() as scheduler:
            return int(main([verb, cut_short(rest[0]), *rest[1:], "--scheduler", scheduler]) not in (0, 1))
    if verb == "view":
        return 0 if run_folder.recording(Path(rest[0])).stat().st_size else 1
    if verb == "search":
        shortened = [cut_short(rest[0]), *rest[1:], "--workers", "1"]
    elif verb in ("run", "blame") and (rest[0] in listing.paths() or rest[0].endswith(VARIANT.name)):
        shortened = [*rest, "--duration", SHORT_S]
    elif verb == "paper":
        shortened = [str(short_run.result().save("short").out)]
    else:
        shortened = rest
    code = main([verb, *shortened])
    return 0 if shortened != rest and code == 1 else code  # expectations may fail in so short a run


def cut_short(study: str) -> str:
    """Write a shipped study with one run, or with two trials of a search, into the current folder."""
    document = tomllib.loads(listing.studies()[study].read_text(encoding="utf-8")) | {"seeds": 1}
    if "search" in document:
        document["search"]["trials"] = 2
    else:
        document["vary"] = [vary | {"values": vary["values"][:1]} for vary in document["vary"]]
    path = Path(f"{study}.toml")
    path.write_text(tomli_w.dumps(document), encoding="utf-8")
    return str(path)


@pytest.fixture(scope="module")
def newcomer(tmp_path_factory):
    """A folder in which every command of the README and of the first page was executed, and the exit codes."""
    folder = tmp_path_factory.mktemp("clone")
    (folder / "docs").symlink_to(ROOT / "docs")
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        patch.syspath_prepend(folder)
        typed = dict.fromkeys(shlex.join(words) for page in (README, INDEX) for words in commands(page))
        codes = {line: follow(shlex.split(line)) for line in typed if line.startswith("luxloop ")}
    return folder, codes


@pytest.mark.slow
def test_every_command_of_the_readme_and_the_first_page_runs(newcomer):
    _, codes = newcomer
    assert any("--tracker docs.examples.my_tracker" in command for command in codes)
    for example in EXAMPLES.values():
        assert any(f"docs/examples/{example}" in command for command in codes)
    assert set(codes.values()) == {0}, codes


def test_the_readme_is_short_and_begins_with_a_picture():
    lines = README.read_text(encoding="utf-8").splitlines()
    assert len(lines) <= 110
    assert any(re.match(r"!\[.+\]\(docs/pictures/", line) for line in lines[:15])


def test_the_index_and_the_navigation_list_every_page_in_the_same_order():
    linked = re.findall(r"^\| \[[^]]+\]\(([\w-]+\.md)\)", INDEX.read_text(encoding="utf-8"), re.MULTILINE)
    navigation = re.findall(r"^ +- .+: ([\w-]+\.md)$", (ROOT / "mkdocs.yml").read_text(encoding="utf-8"), re.MULTILINE)
    assert navigation == [INDEX.name, *linked]
    assert sorted(navigation) == sorted(path.name for path in (ROOT / "docs").glob("*.md"))


def test_every_command_and_every_option_of_run_is_listed():
    known = typer.main.get_command(app).commands
    text = COMMANDS.read_text(encoding="utf-8")
    assert re.findall(r"^\| `luxloop ([\w-]+)", text, re.MULTILINE) == list(known)
    options = [name for option in known["run"].params for name in option.opts if name.startswith("--")]
    assert re.findall(r"^\| `(--[\w-]+)", text, re.MULTILINE) == options


def test_the_citation_and_the_changelog_are_of_this_version():
    version = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]["version"]
    citation, changes = ((ROOT / name).read_text(encoding="utf-8") for name in ("CITATION.cff", "CHANGELOG.md"))
    (released,) = re.findall(rf"^## \[{re.escape(version)}\] - ([\d-]+)$", changes, re.MULTILINE)
    assert f"\nversion: {version}\ndate-released: {released}\n" in citation
    assert f"version = {{{version}}}" in README.read_text(encoding="utf-8")


def test_every_make_target_that_is_named_exists():
    targets = re.search(r"^\.PHONY: (.*)$", (ROOT / "Makefile").read_text(), re.MULTILINE)[1].split()
    typed = {words[1] for page in (README, INDEX) for words in commands(page) if words[0] == "make"}
    named = {name for page in PAGES for name in re.findall(r"`make (\w+)`", page.read_text(encoding="utf-8"))}
    assert typed == {"demo", "test"}
    assert typed | named <= set(targets)


@pytest.mark.slow
def test_the_python_example_reads_the_tables(newcomer, monkeypatch):
    monkeypatch.chdir(newcomer[0])
    (code,) = blocks(RESULTS, "python")
    exec(compile(code, RESULTS.name, "exec"), {})


@pytest.mark.parametrize("page", EXAMPLES, ids=lambda page: page.name)
def test_pages_quote_their_example_scenario(page):
    assert blocks(page, "toml") == [(ROOT / "docs" / "examples" / EXAMPLES[page]).read_text(encoding="utf-8")]


def test_pages_show_the_first_screen_as_it_is_printed():
    """Verdict, limits, figures and commands are today's. Values may differ between machines."""
    again = "run: python docs/figures.py report"
    lines = block(INDEX, "report").splitlines()[1:-1]
    expect = Scenario.load(listing.find(screens.REPORTED)).expect
    assert len(lines) <= 20
    assert max(map(len, lines)) <= screens.COLUMNS
    known = sum(bool(limit.known_failure) for limit in expect.values())
    held = f"{len(expect) - known} of {len(expect)} expectations hold, {known} known failures"
    assert lines[0] == f"PASSED  sumo-crossing, seed 1: {held}", again
    failing = {line.split()[0]: line for line in lines if " < " in line or " > " in line}
    (more,) = re.findall(r"and (\d+) more", "\n".join(lines)) or [0]
    assert set(failing) <= {name for name, limit in expect.items() if limit.known_failure}, again
    assert len(failing) + int(more) == known, again
    title = next(k for k, line in enumerate(lines) if line.startswith("Main figures"))
    labels = list(ON_FIRST_SCREEN.values())[: first_screen.MOST_FIGURES]
    assert [re.split(r"  +", line.strip())[0] for line in lines[title + 1 : title + 1 + len(labels)]] == labels, again
    commands = first_screen.commands_of(Path("runs/sumo-crossing-seed1"), recorded=True)
    assert lines[-2:] == [line.plain for line in first_screen.next_commands(commands, screens.COLUMNS)], again
    assert block(README, "figures").splitlines()[1:-1] == [*lines[:2], *lines[title : title + 1 + len(labels)]]


def test_the_quoted_screen_is_that_of_the_run(tmp_path):
    run_folder.write(tmp_path, short_run.result(), [], "")
    lines = screens.screen(ReportedRun.read(tmp_path))
    assert lines[0].startswith("NO LIMITS  short, seed 4")
    assert lines[-2].startswith("luxloop view runs/short-seed4  ")


@pytest.mark.slow
def test_the_commands_of_the_page_of_the_paper_run(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "docs").symlink_to(ROOT / "docs")
    assert [follow(words) for words in commands(PAPER)] == [0, 0, 0]
    described = re.findall(r"^\| `([\w.]+)` \|", section(RESULTS, "The data set"), re.MULTILINE)
    assert {path.name for path in (tmp_path / "campus").iterdir()} == set(described)


@pytest.mark.slow
def test_the_commands_of_the_page_of_emergence_run(tmp_path, monkeypatch):
    """Each study with one seed and the first value of each parameter."""
    monkeypatch.chdir(tmp_path)
    typed = [
        shlex.split(line, comments=True)
        for line in re.findall(r"^luxloop .*$", chapter(STRESS, "Emergence"), re.MULTILINE)
    ]
    assert [words[:2] for words in typed] == [["luxloop", "sweep"]] * 4
    for words in typed:
        one_seed = ["1" if before == "--seeds" else word for before, word in zip(["", *words], words, strict=False)]
        assert follow(one_seed) == 0


def test_the_paper_s_own_tracker_is_quoted_and_drives_through_paper_campus():
    text = VARIANT.read_text(encoding="utf-8")
    assert blocks(TRACKER, "toml") == [text[text.index("[tracker") :]]
    shipped, own = listing.paths()["paper-campus"].read_text(encoding="utf-8"), tomllib.loads(text)
    moved = tomllib.loads(shipped.replace('"paper-campus/', '"../../scenarios/catalog/urban/paper-campus/'))
    for document in (moved, own):
        for key in ("description", "reason", "expect", "tracker"):
            document.pop(key, None)
    assert own == moved
    assert Scenario.load(VARIANT).tracker.mma.method == "paper"


def test_every_table_of_keys_has_its_place():
    """If this fails, add the heading and the `keys of` and `end` marks of the new table by hand."""
    documented = set(re.findall(r"<!-- keys of (\w+) -->", KEYS.read_text(encoding="utf-8")))
    assert documented == {"Scenario", *Scenario.model_json_schema()["$defs"]}


RIGS = chapter(KEYS.name, "Rig and unit files")
"""Its examples have a test of their own, tests/sensor_model/rig/test_rig_files.py."""


@pytest.mark.parametrize(
    "text", [text for text in blocks(KEYS, "toml") if text not in RIGS], ids=lambda text: text.split("\n")[0][:40]
)
def test_examples_of_scenario_files_are_valid(text, tmp_path, monkeypatch):
    """Complete examples also run, except those with a fictitious net; partial ones extend a complete scenario."""
    monkeypatch.chdir(tmp_path)
    document = tomllib.loads(text)
    path = short_run.write(tmp_path, text if "duration_s" in document else f"{short_run.TEXT}\n{text}")
    traffic = Scenario.load(path).traffic
    if "duration_s" in document and traffic.kind != "sumo":
        assert main(["run", str(path), "--duration", "0.4", "--no-recording"]) == 0


def test_the_points_of_the_example_are_those_of_its_scenario(tmp_path):
    load_script(DOCS / "export_points.py").write(tmp_path / "points.csv")
    written, committed = ((folder / "points.csv").read_bytes() for folder in (tmp_path, DOCS / "examples"))
    assert written == committed, "run: python docs/export_points.py, then python docs/figures.py output"


def test_the_page_shows_what_the_tracker_alone_prints_where_there_is_no_simulator():
    """Figures may differ from machine to machine."""
    command = ["docs/examples/track_csv.py", "docs/examples/points.csv"]
    assert ["python", *command] in commands(TRACKER)
    alone = f"import runpy, sys; sys.modules.update(dict.fromkeys({ABSENT})); sys.argv = {command}"
    run = f"{alone}; runpy.run_path({command[0]!r}, run_name='__main__')"
    printed = subprocess.run([sys.executable, "-c", run], cwd=ROOT, capture_output=True, text=True, check=True).stdout
    shown = "\n".join(block(TRACKER, "output").splitlines()[1:-1])
    assert without_figures(shown) == without_figures(printed), "run: python docs/figures.py output"
    assert "confirmed" in shown


def without_figures(text: str) -> list[list[str]]:
    return [re.sub(r"-?\d+\.\d+", "#", line).split() for line in text.splitlines()]


@pytest.mark.slow
def test_the_python_examples_of_the_pages_run_and_leave_no_file(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    names = {"__name__": "page"}
    for page in (COMMANDS, TRACKER):
        for code in blocks(page, "python"):
            exec(compile(code, page.name, "exec"), names)
    assert list(tmp_path.iterdir()) == []
    assert names["again"].trace_hash == names["result"].trace_hash
    assert names["with_arguments"].trace_hash != names["blind"].trace_hash
    assert names["comparison"].verdict in ("same", "cannot tell")
    assert names["message"].startswith("truck-shadw: no such scenario; did you mean truck-shadow")
    assert names["y"] == pytest.approx(3.0 + 0.5 * names["width"], abs=0.05)
    assert len(names["observations"]) == 1


def test_the_page_lists_the_python_interface():
    listed = {name for cell in re.findall(r"^\| (`.*?`) \|", COMMANDS.read_text(encoding="utf-8"), re.MULTILINE)
              for name in re.findall(r"`(\w+)`", cell)}  # fmt: skip
    assert {*luxloop.__all__} - {"__version__"} <= listed
    arguments = inspect.signature(luxloop.run).parameters.keys() - {"scenario", "step_timeout_s", "ahead"}
    assert arguments <= listed


COMMON = ("arrays", "compiled", "elementary", "elementwise")
"""Modules that simulator, sensor and tracker share."""


def test_the_page_lists_every_package_that_the_tracker_imports():
    common = [ROOT / "luxloop" / f"{name}.py" for name in COMMON]
    trees = [ast.parse(path.read_text(encoding="utf-8")) for path in (*common, *(ROOT / "tracker").rglob("*.py"))]
    nodes = [node for tree in trees for node in ast.walk(tree)]
    imported = {alias.name for node in nodes if isinstance(node, ast.Import) for alias in node.names}
    imported |= {node.module for node in nodes if isinstance(node, ast.ImportFrom)}
    own = {
        name
        for name in imported
        if name.partition(".")[0] == "luxloop" and not f"{name}.".startswith("luxloop.tracker.")
    }
    assert own <= {"luxloop", *(f"luxloop.{name}" for name in COMMON)}
    of_luxloop = [node.names for node in nodes if isinstance(node, ast.ImportFrom) and node.module == "luxloop"]
    assert {alias.name for names in of_luxloop for alias in names} <= set(COMMON)
    others = {name.partition(".")[0] for name in imported} - {*sys.stdlib_module_names, "luxloop"}
    assert others == set(re.findall(r"^\| `(\w+)` \|", section(TRACKER, "The tracker alone"), re.MULTILINE))
    (installed,) = (words[2:] for words in commands(TRACKER) if words[:2] == ["pip", "install"] and "." not in words)
    assert others == set(installed)


def test_every_metric_is_listed_with_its_unit():
    listed = {}
    rows = re.findall(r"^\| `([\w.<>]+)` \| ([\w/^]+) \|", section_tree(RESULTS, "Metrics"), re.MULTILINE)
    for pattern, unit in rows:
        listed |= dict.fromkeys(expand(pattern), unit)
    assert listed == {name: definition.unit for name, definition in DEFINITIONS.items()}


def expand(pattern: str) -> list[str]:
    values = {
        "corner": CORNER_FIGURES,
        "percent": [str(percent) for percent in COVERAGES],
        "limit": [str(limit) for limit in WITHIN_DEG],
        "horizon": HORIZONS,
        "axis": "xy",
        "drive": DRIVERS.values(),
        "stage": TIMED_STAGES,
        "quantile": ("p50", "p99"),
        "users": GROUPS,
    }
    names = [pattern]
    for placeholder in re.findall(r"<(\w+)>", pattern):
        names = [name.replace(f"<{placeholder}>", value) for name in names for value in values[placeholder]]
    return names


def test_every_parameter_is_listed_with_its_values_and_every_filter():
    values: dict[str, set[str]] = {}
    for definition in DEFINITIONS.values():
        for name, choices in definition.parameters.items():
            values.setdefault(name, set()).update(set(choices) - {REQUIRED})
    rows = dict(re.findall(r"^\| `(\w+)` \| (.*) \|$", section(RESULTS, "Names"), re.MULTILINE))
    listed = {name: set(re.findall(r"`([\w-]+)`", rows[name])) for name in values}
    assert listed == values
    assert rows.keys() == {*FILTERS, *values}
    assert {*CLASSES, *VIEWS.values(), NO_VIEW} <= set(re.findall(r"`(\w+)`", rows["class"] + rows["view"]))


def test_former_names_of_metrics_are_those_of_the_table():
    rows = re.findall(r"^\| `(.*)` \| `(.*)` \|$", section(RESULTS, "Former names"), re.MULTILINE)
    values = {
        "method": "jlinkage", "figure": "heading_mean_deg", "view": "side", "cause": "rain", "model": "cv",
        "mode": "ca", "group": "person", "stage": "located", "metric": "track.gospa_m", "class": "bus",
    }  # fmt: skip
    used = set()
    for former, present in rows:
        old, new = (re.sub(r"<(\w+)>", lambda match: values[match[1]], text) for text in (former, present))
        assert present_name(old) == new
        assert present_name(new) == ""
        base = re.sub(r"\.by_.*", "", old)
        used.add(next(pattern for pattern, _, _ in FORMER if re.fullmatch(pattern, base)))
    assert used == {pattern for pattern, _, _ in FORMER}
    assert present_name("fit.best.iou_mean") == "fit.iou_mean"


@pytest.mark.parametrize("table", ["truth", "ego", "tracks", "overlaps", "fits", "segments", "outliers"])
def test_every_column_is_listed(table):
    listed = names_in_rows(section(RESULTS, table))
    assert sorted(["frame", "time_s", *listed]) == sorted(short_run.result().tables[table].columns)


@pytest.mark.parametrize(
    ("table", "columns"),
    [
        ("occlusions", occlusions.COLUMNS),
        ("blockers", frame_tables.BLOCKERS),
        ("events", truth_event.COLUMNS),
        ("extremes", frame_tables.EXTREMES),
    ],
)
def test_every_column_of_occlusions_is_listed(table, columns):
    listed = names_in_rows(section_tree(RESULTS, "Tables").partition(f"### {table}\n")[2].partition("\n### ")[0])
    assert sorted({"frame", "time_s", *listed}) == sorted({"frame", "time_s", *columns})


def test_every_column_of_emergence_is_listed():
    listed = names_in_rows(section_tree(RESULTS, "Tables").partition("### emergence\n")[2].partition("\n### ")[0])
    assert {"frame", "time_s", *listed} >= set(emergence.COLUMNS)


def test_every_column_of_a_controlled_ego_s_drive_is_listed():
    assert ["frame", "time_s", *names_in_rows(section(RESULTS, "control"))] == [*ego_driver.COLUMNS, "driver"]


def names_in_rows(text: str) -> list[str]:
    """Code in the first column of a table."""
    cells = re.findall(r"^\| (`.*?) \|", text, re.MULTILINE)
    return [name for cell in cells for name in re.findall(r"`(\w+)`", cell)]


def test_every_table_and_every_field_of_the_result_is_listed():
    result = short_run.result()
    described = re.findall(r"^### (\w+)$", section_tree(RESULTS, "Tables"), re.MULTILINE)
    assert sorted(described) == sorted([*result.tables, "control"])
    fields = re.findall(
        r"`(\w+)`", "".join(re.findall(r"^\| (`.*?) \|", section(RESULTS, r"result\.json"), re.MULTILINE))
    )
    assert fields == list(run_folder.document(result, []))


@each_page
def test_links_resolve(page):
    for target, anchor in re.findall(r"\]\((?!https?:)([^)#]*)#?([^)]*)\)", page.read_text(encoding="utf-8")):
        linked = page.parent / target if target else page
        assert linked.exists(), target
        if anchor:
            titles = re.findall(r"^#+ (.*)$", linked.read_text(encoding="utf-8"), re.MULTILINE)
            assert anchor in {re.sub(r"[^\w\- ]", "", title.lower()).replace(" ", "-") for title in titles}


@pytest.mark.parametrize("page", [*PAGES, ROOT / "docs" / "pictures" / "data_flow.svg"], ids=lambda page: page.name)
def test_files_that_are_named_exist(page):
    text = page.read_text(encoding="utf-8")
    folders = "sim|sensor_model|tracker|scenarios|tests|docs|benchmarks"
    names = re.findall(rf"(?<![\w./-])((?:{folders})/[\w./-]+\.(?:py|toml|json|md|cff))", text)
    assert {name for name in names if not (ROOT / name).exists()} <= MADE_LATER
    assert not re.search(r"/(?:work|root|home|tmp)/", text), "a path of one machine"


def test_pictures_are_shown_and_small():
    texts = [page.read_text(encoding="utf-8") for page in PAGES]
    shown = {name for text in texts for name in re.findall(r"pictures/(\w+\.(?:png|gif|svg))\)", text)}
    pictures = {path.name: path.stat().st_size for path in (ROOT / "docs" / "pictures").iterdir()}
    assert shown == set(pictures)
    for name, size in pictures.items():
        assert size < (2_000_000 if name.endswith(".gif") else 300_000), name
