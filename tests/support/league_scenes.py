"""Tiny scenarios for the league."""

from pathlib import Path

SCENE = """\
description = "A car ahead and one that comes the other way."
duration_s = 2.0

[traffic]
kind = "scripted"
ego = {{ motion = [{{ kind = "straight", speed_mps = 8.0 }}] }}
actor = [
    {{ x_m = 12.0, y_m = {y_m}, motion = [{{ kind = "straight", speed_mps = 9.0 }}] }},
    {{ x_m = 30.0, y_m = 4.0, yaw_deg = 180.0, motion = [{{ kind = "straight", speed_mps = 8.0 }}] }},
]
"""


def write(folder: Path) -> list[str]:
    """Write two scenarios and return their paths."""
    paths = []
    for name, y_m in (("left", 3.5), ("right", -3.5)):
        path = folder / f"{name}.toml"
        path.write_text(SCENE.format(y_m=y_m), encoding="utf-8")
        paths.append(str(path))
    return paths
