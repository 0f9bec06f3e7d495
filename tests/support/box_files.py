"""Files of boxes in every format that luxloop grades, written line by line from one list of boxes."""

import json
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest

from luxloop.scenarios.cli import main


class Box(NamedTuple):
    """A box on the ground, x forward and y left."""

    frame: int
    id: str
    x: float
    y: float
    heading: float
    length: float
    width: float
    score: float = 0.5
    kind: str = "car"


def csv(boxes: list[Box]) -> str:
    rows = [
        f"{b.frame},{b.id},{b.x!r},{b.y!r},{b.heading!r},{b.length!r},{b.width!r},{b.score!r},{b.kind}" for b in boxes
    ]
    return "\n".join(["frame,id,x_m,y_m,heading_rad,length_m,width_m,score,class", *rows]) + "\n"


def kitti(boxes: list[Box], *, scored: bool = True) -> str:
    """KITTI's camera looks along x: x right, y down, z forward, rotation_y clockwise from its x axis."""
    lines = []
    for b in boxes:
        score = f" {b.score!r}" if scored else ""
        at = f"{-b.y!r} 1.7 {b.x!r} {float(-b.heading - np.pi / 2)!r}"
        lines.append(f"{b.frame} {b.id} {b.kind.title()} 0 0 0 0 0 0 0 1.5 {b.width!r} {b.length!r} {at}{score}")
    return "".join(f"{line}\n" for line in lines)


def nuscenes(boxes: list[Box], *, scored: bool = True) -> str:
    results: dict[str, list[dict]] = {f"s{frame}": [] for frame in range(max((b.frame for b in boxes), default=0) + 1)}
    for b in boxes:
        row = {
            "sample_token": f"s{b.frame}", "translation": [b.x, b.y, 0.75], "size": [b.width, b.length, 1.5],
            "rotation": [float(np.cos(b.heading / 2)), 0.0, 0.0, float(np.sin(b.heading / 2))],
            "velocity": [1.0, 0.0], "tracking_id": b.id, "tracking_name": b.kind,
        }  # fmt: skip
        results[f"s{b.frame}"].append(row | ({"tracking_score": b.score} if scored else {}))
    return json.dumps({"meta": {"use_lidar": True}, "results": results})


def write(folder: Path, name: str, text: str) -> Path:
    path = folder / name
    path.write_text(text, encoding="utf-8")
    return path


def drive(seed: int, frames: int = 12, cars: int = 5) -> tuple[list[Box], list[Box]]:
    """Return true boxes and noisy tracks with gaps, switched ids and false tracks."""
    rng = np.random.default_rng(seed)
    truth, tracks = [], []
    for frame in range(frames):
        for car in range(cars):
            x, y, heading = 3.0 * frame + 9.0 * car, 4.0 * car, 0.2 * car
            length, width = 4.0 + 0.2 * car, 1.8
            if rng.random() < 0.9:
                truth.append(Box(frame, f"{car}", x, y, heading, length, width))
            if rng.random() < 0.8:
                number = car + 10 * int(rng.random() < 0.1)
                right, ahead = rng.normal(0.0, 0.3, 2).tolist()
                sure = float(rng.uniform(0.2, 1.0))
                turn = heading + rng.normal(0.0, 0.05)
                tracks.append(Box(frame, f"{number}", x + right, y + ahead, float(turn), length, width, sure))
        if rng.random() < 0.3:
            tracks.append(Box(frame, f"{100 + frame}", float(rng.uniform(0, 80)), 30.0, 0.0, 4.0, 1.8, 0.3))
    return truth, tracks


def grades(capsys, truth, tracks):
    """Return the values of the metrics of two files, without the height: tables of tracks have none."""
    assert main(["grade", "--truth", str(truth), "--tracks", str(tracks), "--json"]) == 0
    found = json.loads(capsys.readouterr().out)["metrics"]
    return {name: row["value"] for name, row in found.items() if name != "track.height_abs_mean_m"}


def assert_same_grades(found, own):
    """Check metrics up to the order of sums; tables have no times and no ranges, which other formats have."""
    known = {name for name, value in own.items() if value is not None}
    more = {name for name, value in found.items() if value is not None} - known
    assert not [name for name in more if "time_to_confirm" not in name and "range=" not in name]
    differ = {
        name: (found.get(name), own[name]) for name in known if found.get(name) != pytest.approx(own[name], abs=1e-12)
    }
    assert not differ, differ
