"""Broken input of every kind: a valid command line per kind, with its files, and mutations of one of them."""

import random
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import pyarrow as pa
from support import bad_input_files as valid
from support import bad_traffic_files as traffic
from support.bad_arguments import arguments
from support.mutate_content import BYTES, TEXT, XML, Way, mutated
from support.mutate_tables import mutated_table

Files = dict[str, bytes]


@dataclass(frozen=True)
class Case:
    """A command line with broken input."""

    files: Files
    """Content of the files by path in the current folder."""
    command: list[str]
    how: str
    """Names of the mutations, for messages."""


RUN = ["run", "a.toml", "--no-recording", "--json", "--out", "out", "--duration", "0.16"]
"""Two frames, also if the duration in the file is mutated."""
AHEAD_EVERY = 5
"""One of so many runs reads its traffic in a process of its own, of which a refused run needs a new one: a second."""


def of_content(files: Callable[[], Files], name: str, command: list[str], ways: tuple[Way, ...]) -> "Kind":
    """Return a kind that mutates the bytes of the file `name`."""

    def make(rng: random.Random) -> Case:
        made = dict(files())
        made[name], how = mutated(rng, made[name], ways)
        return Case(made, command, f"{name}: {how}")

    return make


def of_table(
    files: Callable[[], Files], name: str, table: Callable[[], pa.Table], command: list[str], share: float = 0.8
) -> "Kind":
    """Return a kind that mutates the table of a Parquet file, or the file's bytes."""

    def make(rng: random.Random) -> Case:
        made = dict(files())
        if rng.random() < share:
            made[name], how = mutated_table(rng, table())
        else:
            made[name], how = mutated(rng, made[name], BYTES)
        return Case(made, command, f"{name}: {how}")

    return make


def of_part(files: Callable[[], Files], name: str, command: list[str]) -> "Kind":
    """Return a kind that mutates a Parquet file among `files`."""
    return of_table(files, name, valid.table_of(files, name), command)


def either(*kinds: "Kind") -> "Kind":
    """Return a kind that is one of several at random."""
    return lambda rng: rng.choice(kinds)(rng)


Kind = Callable[[random.Random], Case]

SWEEP = ["sweep", "study.toml", "--scheduler", "127.0.0.1:9", "--out", "out"]
"""No scheduler listens there: a study that is good ends with that error."""
GRADE = ["grade", "run", "--json", "--out", "out"]
TRACKS = [*GRADE, "--tracks", "tracks.csv"]
GRADE_REC = ["grade", "rec", "--json", "--out", "out"]
TABLES, LABELS = "scene/v1.0-luxloop", "run/scans/labels.parquet"


def of_files(truth: str, tracks: str) -> list[str]:
    """Return the command that grades two files."""
    return ["grade", "--truth", truth, "--tracks", tracks, "--json"]


SCENE = of_files("scene", "scene/tracking_result.json")
TRACK = ["track", "rec", "--no-recording", "--out", "out"]
IMPORT = ["import", "--out", "out", "--mount", "0,0,1"]

KINDS: dict[str, Kind] = {
    "scenario": of_content(traffic.scenario, "a.toml", RUN, TEXT),
    "study": of_content(traffic.study, "study.toml", SWEEP, TEXT),
    "rig": of_content(traffic.rig, "rig.toml", RUN, TEXT),
    "unit": of_content(traffic.rig, "unit.toml", RUN, TEXT),
    "csv": either(
        of_content(traffic.csv, "drive.csv", RUN, TEXT),
        of_content(traffic.csv_gz, "drive.csv.gz", RUN, BYTES),
    ),
    "parquet": of_table(traffic.parquet_drive, "drive.parquet", traffic.drive, RUN),
    "fcd": either(
        of_content(traffic.fcd, "drive.xml", RUN, XML),
        of_content(traffic.fcd, "drive.xml", RUN, XML),
        of_content(traffic.fcd_gz, "drive.xml.gz", RUN, BYTES),
    ),
    "commonroad": of_content(traffic.commonroad, "drive.xml", RUN, XML),
    "openscenario": either(*(of_content(traffic.openscenario, f"cut-in.{end}", RUN, XML) for end in ("xosc", "xodr"))),
    "sumo": either(
        *(of_content(traffic.sumo, name, RUN, XML) for name in ("a.net.xml", "a.rou.xml", "a.add.xml", "a.sumocfg"))
    ),
    "tracks": either(
        of_content(valid.tracks_csv, "tracks.csv", [*GRADE, "--tracks", "tracks.csv"], TEXT),
        of_table(valid.tracks_parquet, "tracks.parquet", valid.tracks, [*GRADE, "--tracks", "tracks.parquet"]),
    ),
    "boxes": either(
        *(of_content(valid.boxes, f"{name}{end}", of_files(f"a{end}", f"b{end}"), TEXT)
          for name in "ab" for end in (".csv", ".txt", ".json")),
        *(of_content(valid.nuscenes_folder, f"{TABLES}/{name}.json", SCENE, TEXT)
          for name in ("sample", "sample_annotation", "instance", "category")),
        of_content(valid.boxes_mcap, "run.mcap", of_files("run.mcap", "run.mcap"), BYTES),
        of_content(valid.boxes_osi, "trace.mcap", of_files("trace.mcap", "trace.mcap"), BYTES),
        of_part(valid.run, LABELS, of_files(LABELS, "run/tables/tracks.parquet")),
    ),
    "imports": either(
        of_content(valid.bin_scan, "a.bin", [*IMPORT, "a.bin"], BYTES),
        of_content(valid.pcd_ascii, "a.pcd", [*IMPORT, "a.pcd"], TEXT),
        of_content(valid.pcd_binary, "a.pcd", [*IMPORT, "a.pcd"], TEXT),
        of_content(valid.pcd_compressed, "a.pcd", [*IMPORT, "a.pcd"], TEXT),
        of_content(valid.lux, "a.lux", ["import", "--out", "out", "--rig", "one.toml", "a.lux"], BYTES),
        *(
            of_content(bag, name, [*IMPORT, "--odometry", "/ego", "--truth", "/car=4.5,1.8", name], BYTES)
            for name, bag in (("a.bag", valid.bag), ("a.mcap", valid.mcap), ("a.db3", valid.sqlite))
        ),
    ),
    "scans": either(
        of_content(valid.recording, "rec/summary.json", TRACK, TEXT),
        of_part(valid.recording, "rec/scans.parquet", GRADE_REC),
        of_part(valid.recording, "rec/points.parquet", TRACK),
        of_part(valid.recording, "rec/labels.parquet", GRADE_REC),
    ),
    "runs": either(
        of_content(valid.run, "run/result.json", GRADE, TEXT),
        of_content(valid.run, "run/result.json", ["report", "run"], TEXT),
        of_content(valid.run, "run/result.json", ["baseline", "run", "--out", "out.jsonl"], TEXT),
        of_part(valid.run, "run/tables/tracks.parquet", GRADE),
        of_part(valid.run, "run/tables/truth.parquet", ["compare", "run", "run"]),
        of_part(valid.run, "run/scans/points.parquet", TRACKS),
        of_part(valid.run, "run/scans/labels.parquet", TRACKS),
    ),
    "baseline": either(
        of_content(valid.baseline, "base.jsonl", ["compare", "base.jsonl", "head.jsonl"], TEXT),
        of_content(valid.baseline, "base.jsonl", ["compare", "head.jsonl", "base.jsonl", "--json"], TEXT),
        of_content(valid.baseline, "base.jsonl", ["trends", "head.jsonl", "base.jsonl", "--out", "trends.html"], TEXT),
    ),
    "arguments": lambda rng: Case(valid.all_files(), *arguments(rng)),
}  # fmt: skip

ALL = {
    "scenario": 1400, "study": 800, "rig": 600, "unit": 600, "csv": 900, "parquet": 900, "fcd": 700, "commonroad": 500,
    "openscenario": 500, "sumo": 400, "tracks": 900, "boxes": 800, "imports": 800, "scans": 400, "runs": 500,
    "baseline": 550, "arguments": 750,
}  # fmt: skip
"""Numbers of mutations by kind."""


BOMBS: dict[str, Callable[[], Files]] = {
    "bomb-csv": traffic.csv_bomb,
    "bomb-fcd": traffic.fcd_bomb,
    "bomb-parquet": traffic.parquet_bomb,
    "bomb-sumo": traffic.sumo_bomb,
}
"""Small files that expand to gigabytes."""


def case(kind: str, number: int) -> Case:
    """Return a case, always the same for its kind and number."""
    if kind in BOMBS:
        return Case(BOMBS[kind](), RUN, "bomb")
    made = KINDS[kind](random.Random(f"{kind} {number}"))
    return replace(made, command=[*RUN, "--no-ahead"]) if made.command == RUN and number % AHEAD_EVERY else made


def write(files: Files, folder: Path) -> None:
    """Write the files of a case."""
    for name, content in files.items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(content)
