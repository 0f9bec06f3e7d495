"""Valid files of traffic, and what names them: scenarios, studies, rigs, recordings of traffic, nets of SUMO."""

import gzip
import io
from functools import cache

import numpy as np
import pyarrow as pa
import pyarrow.csv
from support import short_run
from support.mutate_tables import bomb, parquet
from support.paths import EXAMPLES, NETS, ROOT

Files = dict[str, bytes]

SHORT = short_run.TEXT.replace("duration_s = 0.8", "duration_s = 0.16")
REPLAY = """\
description = "A recording, for two frames."
duration_s = 0.16

[traffic]
kind = "replay"
file = "{file}"
ego = "{ego}"
"""
SUMO = """\
description = "SUMO, for two frames."
duration_s = 0.16

[traffic]
kind = "sumo"
config = "a.sumocfg"
ego = "vehicle:v"
max_wait_s = 5
"""
STUDY = """\
description = "Dropout against a car that drives past."
scenario = "a.toml"
seeds = 2

[fixed]
duration_s = 0.1

[[metric]]
name = "own.near"
of = "track.missed"
class = "car"

[[vary]]
key = "noise.dropout.random_rate"
values = [0.0, 0.1]
neutral = 0.0

[[vary]]
key = "noise.range.sigma_scale"
low = 0.5
high = 2.0
steps = 3
neutral = 1.0

[[curve]]
metric = "track.hota"
against = "noise.dropout.random_rate"
by = "noise.range.sigma_scale"

[search]
metric = "track.hota"
min = 0.5
trials = 5
"""
CAR = "<rectangle><length>4.4</length><width>1.8</width></rectangle>"


@cache
def scenario() -> Files:
    """A scripted scenario with expectations, noise and settings of the tracker."""
    more = '[expect]\n"track.mota" = { max = 1.0, unit = "1" }\n[noise.dropout]\nrandom_rate = 0.1\n'
    more += '[tracker.filters]\nmodels = ["cv"]\n'
    return {"a.toml": (SHORT + more).encode()}


@cache
def study() -> Files:
    return {"a.toml": SHORT.encode(), "study.toml": STUDY.encode()}


@cache
def small_study() -> Files:
    """A study of two runs."""
    text = STUDY.partition("[[metric]]")[0] + "[[vary]]" + STUDY.partition("[[vary]]")[2].partition("[[vary]]")[0]
    return {"study.toml": text.encode()}


@cache
def rig() -> Files:
    text = (ROOT / "sensor_model" / "rigs" / "srx_six_lux.toml").read_text(encoding="utf-8")
    text = "\n".join(text.replace('model = "lux"', 'model = "unit.toml"').split("[[unit]]")[:3])
    text = text.replace("\nname =", "\n[[unit]]\nname =")
    unit = (ROOT / "sensor_model" / "units" / "lux.toml").read_bytes()
    return {"a.toml": (SHORT + '[rig]\nfile = "rig.toml"\n').encode(), "rig.toml": text.encode(), "unit.toml": unit}


@cache
def drive() -> pa.Table:
    """Two cars and a pedestrian for three seconds."""
    time = np.arange(31) / 10.0
    one = {"yaw_deg": np.zeros(31), "length_m": np.full(31, 4.5), "reflectivity": np.full(31, 0.4)}
    parts = [
        pa.table(
            {"time_s": time, "id": [name] * 31, "x_m": x + v * time, "y_m": np.full(31, y), **one, "kind": [kind] * 31}
        )
        for name, x, v, y, kind in (
            ("7", 0.0, 8.0, 0.0, "car"),
            ("8", 10.0, 9.0, 3.5, "car"),
            ("9", 20.0, 1.0, 6.0, "pedestrian"),
        )
    ]
    return pa.concat_tables(parts)


def _replayed(file: str, content: bytes, ego: str = "7") -> Files:
    return {"a.toml": REPLAY.format(file=file, ego=ego).encode(), file: content}


def as_csv(table: pa.Table) -> bytes:
    stream = io.BytesIO()
    pyarrow.csv.write_csv(table, stream)
    return stream.getvalue()


@cache
def csv() -> Files:
    return _replayed("drive.csv", as_csv(drive()))


@cache
def csv_gz() -> Files:
    return _replayed("drive.csv.gz", gzip.compress(as_csv(drive()), mtime=0))


@cache
def parquet_drive() -> Files:
    return _replayed("drive.parquet", parquet(drive()))


def _fcd() -> bytes:
    steps = [
        f'<timestep time="{k / 10}"><vehicle id="7" x="{k}" y="0" angle="90" type="car" speed="10"/>'
        f'<vehicle id="8" x="{20 + k}" y="3" angle="90" type="car"/>'
        f'<person id="p" x="9" y="{k / 10}" angle="0"/></timestep>'
        for k in range(31)
    ]
    return ("<fcd-export>\n" + "\n".join(steps) + "\n</fcd-export>\n").encode()


@cache
def fcd() -> Files:
    return _replayed("drive.xml", _fcd())


@cache
def fcd_gz() -> Files:
    return _replayed("drive.xml.gz", gzip.compress(_fcd(), mtime=0))


def _state(step: int, x: float, y: float, tag: str = "state") -> str:
    return (
        f"<{tag}><time><exact>{step}</exact></time><position><point><x>{x}</x><y>{y}</y></point></position>"
        f"<orientation><exact>0</exact></orientation><velocity><exact>10</exact></velocity></{tag}>\n"
    )


@cache
def commonroad() -> Files:
    """Two moving cars, a parked one and a building."""
    head = """<?xml version="1.0" ?>
<commonRoad timeStepSize="0.1" commonRoadVersion="2020a" author="" affiliation="" source="" benchmarkID="DEU_A-1_1_T-1"
date="2024-01-01"><location><geoNameId>-999</geoNameId><gpsLatitude>999</gpsLatitude>
<gpsLongitude>999</gpsLongitude></location><scenarioTags><urban/></scenarioTags>
<lanelet id="1"><leftBound><point><x>0</x><y>2</y></point><point><x>99</x><y>2</y></point></leftBound>
<rightBound><point><x>0</x><y>-2</y></point><point><x>99</x><y>-2</y></point></rightBound>
<laneletType>urban</laneletType></lanelet>
"""
    cars = "".join(
        f'<dynamicObstacle id="{number}"><type>car</type><shape>{CAR}</shape>{_state(0, x, y, "initialState")}'
        f"<trajectory>{''.join(_state(k, x + k, y) for k in range(1, 12))}</trajectory></dynamicObstacle>\n"
        for number, x, y in ((7, 0, 0), (8, 12, 3))
    )
    standing = "".join(
        f'<staticObstacle id="{number}"><type>{word}</type><shape>{CAR}</shape>{_state(0, 9, y, "initialState")}'
        "</staticObstacle>\n"
        for number, word, y in ((9, "parkedVehicle", -4), (10, "building", 12))
    )
    return _replayed("drive.xml", (head + cars + standing + "</commonRoad>\n").encode())


@cache
def openscenario() -> Files:
    """The scenario of the documentation, for two frames."""
    text = (EXAMPLES / "cut-in.toml").read_text(encoding="utf-8").replace("duration_s = 15.0", "duration_s = 0.16")
    return {
        "a.toml": text.encode(),
        **{name: (EXAMPLES / name).read_bytes() for name in ("cut-in.xosc", "cut-in.xodr")},
    }


@cache
def sumo() -> Files:
    """A net with a vehicle, a building and a configuration."""
    return {
        "a.toml": SUMO.encode(),
        "a.net.xml": (NETS / "winding" / "winding.net.xml").read_bytes(),
        "a.rou.xml": b'<routes><vType id="t" length="4.5"/><route id="r" edges="start r80"/>\n'
        b'<vehicle id="v" type="t" route="r" depart="0"/><vehicle id="w" route="r" depart="0.5"/></routes>\n',
        "a.add.xml": b'<additional><poly id="b" type="building" shape="5,20 9,20 9,30 5,30">'
        b'<param key="height" value="6"/></poly><poi id="p" type="pole" x="3" y="9"/></additional>\n',
        "a.sumocfg": b'<configuration><input><net-file value="a.net.xml"/><route-files value="a.rou.xml"/>\n'
        b'<additional-files value="a.add.xml"/></input><time><begin value="0"/></time></configuration>\n',
    }


def _gz_bomb(head: bytes, body: bytes) -> bytes:
    """Return a file of four gigabytes: a head, and 64 times a member of 64 MB."""
    return gzip.compress(head) + 64 * gzip.compress(body * (2**26 // len(body)), 9)


def csv_bomb() -> Files:
    return _replayed("drive.csv.gz", _gz_bomb(b"time_s,id,x_m,y_m\n", b"0,1,0,0\n"))


def fcd_bomb() -> Files:
    return _replayed("drive.xml.gz", _gz_bomb(b'<fcd-export><timestep time="0">', b'<vehicle id="7" x="0" y="0"/>'))


def parquet_bomb() -> Files:
    return _replayed("drive.parquet", bomb(drive()))


def sumo_bomb() -> Files:
    return sumo() | {"a.add.xml": _gz_bomb(b"<additional>", b"<a/>")}
