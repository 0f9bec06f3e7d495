"""A recorded run in the formats of other programs: a turning ego, a moving car, a parked truck, a wall and a house."""

from pathlib import Path

from support import short_run

from luxloop.scenarios.cli import main

MOVING = 'ego = { motion = [{ kind = "arc", speed_mps = 3.0, radius_m = 12.0 }] }'
HOUSE = """
[[traffic.obstacle]]
corners_m = [[-12, -20], [-12, -14], [-4, -14], [-4, -20]]
height_m = 6
"""
TEXT = short_run.TEXT.replace('kind = "scripted"', f'kind = "scripted"\n{MOVING}') + HOUSE


def recorded(folder: Path) -> Path:
    """Run the scene with recorded scans in `folder`/run."""
    path = short_run.write(folder, TEXT)
    assert main(["run", str(path), "--out", str(folder / "run"), "--no-recording", "--record-scans"]) == 0
    return folder / "run"


def exported(folder: Path, kind: str) -> Path:
    """Run the scene and export it to `folder`/`kind`; return `folder`."""
    run = recorded(folder)
    assert main(["export", str(run), "--format", kind, "--out", str(folder / kind)]) == 0
    return folder
