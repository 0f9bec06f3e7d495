"""Packages with entry points of luxloop, in a folder for the Python path, and commands that find them."""

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import NamedTuple

from support.paths import ROOT


def write(folder: Path, name: str, entry_points: dict[str, dict[str, str]], code: str = "") -> None:
    """Write a distribution that is a module of the same name, as pip would install it into a folder."""
    (folder / f"{name}.py").write_text(code, encoding="utf-8")
    metadata = folder / f"{name}-1.0.dist-info"
    metadata.mkdir()
    (metadata / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {name}\nVersion: 1.0\n", encoding="utf-8")
    lines = []
    for group, entries in entry_points.items():
        lines += [f"[{group}]", *(f"{key} = {value}" for key, value in entries.items())]
    (metadata / "entry_points.txt").write_text("\n".join(lines) + "\n", encoding="utf-8")


def install_example(folder: Path) -> None:
    """Install the example of the documentation into a folder, without network and without its dependencies."""
    options = ["--no-deps", "--no-index", "--no-build-isolation", "--quiet", "--target", str(folder)]
    command = [sys.executable, "-m", "pip", "install", *options, str(ROOT / "docs" / "examples" / "plugin")]
    subprocess.run(command, check=True, capture_output=True)


class Ended(NamedTuple):
    """Result of a command."""

    code: int
    out: str
    error: str


PROGRAM = """
import io, json, sys
from contextlib import redirect_stderr, redirect_stdout
from luxloop.scenarios.cli import main
results = []
for words in json.loads(sys.argv[1]):
    with redirect_stdout(io.StringIO()) as out, redirect_stderr(io.StringIO()) as error:
        code = main(words)
    results.append((code, out.getvalue(), error.getvalue()))
print(json.dumps(results))
"""


def luxloop(packages: Path, folder: Path, *commands: list[str]) -> list[Ended]:
    """Run commands in a folder, one after the other in one process that finds the packages in another folder."""
    path = os.pathsep.join(filter(None, [os.environ.get("PYTHONPATH"), str(packages)]))
    program = [sys.executable, "-c", PROGRAM, json.dumps(commands)]
    environment = {**os.environ, "PYTHONPATH": path}
    run = subprocess.run(program, cwd=folder, env=environment, capture_output=True, text=True, check=False)
    assert run.returncode == 0, run.stderr
    return [Ended(*result) for result in json.loads(run.stdout)]
