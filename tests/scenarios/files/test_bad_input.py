"""Broken input of every kind: one line and a documented exit code, no traceback, no hang, nothing left on disk.

`pytest -m soak -s tests/scenarios/files/test_bad_input.py` runs all mutations and prints their counts by kind.
"""

import json

import pytest
from support import bad_input, bad_input_files, bad_traffic_files, warm_process
from support.bad_input_child import run_case
from support.few import few
from support.mutate_content import BYTES, XML
from support.mutate_tables import WAYS
from support.optional import need

FAST, SLOW = 3, 6
"""Mutations of some kinds in `make test`, and of each kind in `make slow`: a refused run starts its traffic anew."""
QUICK = ("scenario", "tracks")
"""Kinds of `make test`."""
MOST_MB = 1024.0
MOST_S = 20.0
TIMEOUT_S = 3600.0
NEEDED = {"study": ("sweeps",), "boxes": ("mcap", "osi"), "imports": ("recordings",), "commonroad": ("commonroad",)}
"""Extras by kind of input: valid files of these kinds are written or read by optional packages."""


@pytest.mark.parametrize(
    ("share", "kind"),
    [
        *few([("some", kind) for kind in QUICK], "some"),
        *few([("some", kind) for kind in bad_input.KINDS if kind not in QUICK]),
        *few([("more", kind) for kind in bad_input.KINDS]),
        *(pytest.param("all", kind, marks=pytest.mark.soak) for kind in bad_input.KINDS),
    ],
)
def test_broken_input_is_refused_in_one_line(kind, share):
    for extra in NEEDED.get(kind, ()):
        need(extra)
    first, end = {"some": (0, FAST), "more": (FAST, SLOW), "all": (0, bad_input.ALL[kind])}[share]
    count = end - first
    found = run_child(kind, first, count)
    print(f"{kind}: {count} mutations, exit codes {found['codes']}, at most {max(found['peak_mb']):.0f} MB, "
          f"{found['longest_s'][0]:.1f} s")  # fmt: skip
    assert found["faults"] == []
    assert sum(found["codes"].values()) == count
    assert found["codes"].get("2", 0) > 0
    assert max(found["peak_mb"]) < MOST_MB


def run_child(kind: str, first: int, count: int) -> dict:
    """Run cases of a kind in a process of their own, whose peak memory is that of these cases.

    It is forked from one that has loaded the kernels: a command is taken to hang after seconds, compilation takes
    minutes.
    """
    done = warm_process.run("support.bad_input_child", kind, str(first), str(count), timeout=TIMEOUT_S)
    assert done.returncode == 0, done.stderr[-2000:]
    return json.loads(done.stdout)


def test_there_are_twelve_thousand_mutations_of_all_kinds():
    assert bad_input.ALL.keys() == bad_input.KINDS.keys()
    assert sum(bad_input.ALL.values()) >= 12_000


def test_cases_are_repeatable_and_use_every_mutation():
    """Without variety, the test above would show nothing."""
    assert bad_input.case("fcd", 7) == bad_input.case("fcd", 7)
    for kind, ways in (("fcd", (*XML, *BYTES)), ("parquet", WAYS)):
        how = " ".join(bad_input.case(kind, number).how for number in range(400))
        assert all(way.__name__.strip("_") in how for way in ways), kind


@pytest.mark.slow
def test_the_valid_files_are_accepted(tmp_path, capfd):
    """A base that is itself refused would hide what its mutations do. Standard error is that of the process."""
    for extra in {extra for extras in NEEDED.values() for extra in extras}:
        need(extra)
    with capfd.disabled():
        assert_accepted(tmp_path)


def assert_accepted(tmp_path):
    for number, (files, command) in enumerate(VALID):
        folder = tmp_path / str(number)
        folder.mkdir()
        code, fault = run_case(bad_input.Case(files(), command, "valid"), folder)
        assert code in (0, 1) or command == bad_input.SWEEP, (command, code)
        assert fault == "", (command, fault)


VALID = [
    *((files, bad_input.RUN) for files in (
        bad_traffic_files.scenario, bad_traffic_files.rig, bad_traffic_files.csv, bad_traffic_files.csv_gz,
        bad_traffic_files.parquet_drive, bad_traffic_files.fcd, bad_traffic_files.fcd_gz, bad_traffic_files.commonroad,
        bad_traffic_files.openscenario, bad_traffic_files.sumo,
    )),
    (bad_traffic_files.study, bad_input.SWEEP),
    (bad_input_files.tracks_csv, [*bad_input.GRADE, "--tracks", "tracks.csv"]),
    (bad_input_files.tracks_parquet, [*bad_input.GRADE, "--tracks", "tracks.parquet"]),
    *((bad_input_files.boxes, bad_input.of_files(f"a{end}", f"b{end}")) for end in (".csv", ".txt", ".json")),
    (bad_input_files.nuscenes_folder, bad_input.SCENE),
    (bad_input_files.boxes_mcap, bad_input.of_files("run.mcap", "run.mcap")),
    (bad_input_files.boxes_osi, bad_input.of_files("trace.mcap", "trace.mcap")),
    (bad_input_files.bin_scan, [*bad_input.IMPORT, "a.bin"]),
    (bad_input_files.pcd_ascii, [*bad_input.IMPORT, "a.pcd"]),
    (bad_input_files.pcd_binary, [*bad_input.IMPORT, "a.pcd"]),
    (bad_input_files.pcd_compressed, [*bad_input.IMPORT, "a.pcd"]),
    (bad_input_files.bag, [*bad_input.IMPORT, "a.bag"]),
    (bad_input_files.recording, ["grade", "rec", "--json", "--out", "out"]),
    (bad_input_files.baseline, ["compare", "base.jsonl", "head.jsonl"]),
]  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize("name", ["csv", "fcd", "parquet", "sumo"])
def test_a_small_file_that_expands_to_gigabytes_is_refused(name):
    """In a process of its own, whose memory is measured."""
    found = run_child(f"bomb-{name}", 0, 1)
    assert found["faults"] == []
    assert found["codes"] == {"2": 1}
    assert max(found["peak_mb"]) < MOST_MB
