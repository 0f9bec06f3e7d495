"""Add kernels that are compiled for one processor to a wheel: `python .ci/wheel_kernels.py WHEEL`.

Where the wheel is installed, `luxloop.kernel_folder` selects that processor, so that a first run compiles nothing.
Kernels belong to the Python and the numba that compiled them; with others, luxloop compiles as without them.
"""

import base64
import hashlib
import os
import subprocess
import sys
import tempfile
import zipfile
from importlib.metadata import version
from pathlib import Path

from luxloop.kernel_folder import PROCESSOR, SHIPPED

SCENARIOS = ("sumo-crossing", "tunnel", "motorway-spray", "crosswalk", "tram-street")
"""Together they use the kernels of nearly all scenarios: walls, weather, people and articulated vehicles."""


def main(wheel: Path) -> None:
    """Compile the kernels in a copy of the installed package, and add them to the wheel."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        with zipfile.ZipFile(wheel) as packed:
            packed.extractall(folder)
        compile_kernels(folder)
        (folder / "luxloop" / SHIPPED).write_text(version("numba"), encoding="utf-8")
        pack(folder, wheel)


def compile_kernels(folder: Path) -> None:
    """Run scenarios with the package in this folder; numba writes its cache beside the sources."""
    own = {key: value for key, value in os.environ.items() if not key.startswith(("NUMBA_", "PYTHON"))}
    environment = {**own, **PROCESSOR, "PYTHONPATH": str(folder), "PYTHONDONTWRITEBYTECODE": "1"}
    for scenario in SCENARIOS:
        command = [sys.executable, "-m", "luxloop", "warm-up", scenario, "--quiet"]
        subprocess.run(command, cwd=folder, env=environment, check=True)


def pack(folder: Path, wheel: Path) -> None:
    """Write the files of a folder to a wheel, with their digests in its record."""
    (record,) = folder.glob("*.dist-info/RECORD")
    files = sorted(path for path in folder.rglob("*") if path.is_file() and path != record)
    lines = [f"{path.relative_to(folder)},sha256={digest(path)},{path.stat().st_size}" for path in files]
    record.write_text("\n".join([*lines, f"{record.relative_to(folder)},,", ""]), encoding="utf-8")
    with zipfile.ZipFile(wheel, "w", zipfile.ZIP_DEFLATED) as packed:
        for path in [*files, record]:
            packed.write(path, path.relative_to(folder))


def digest(path: Path) -> str:
    """Return the digest of a file as the format of wheels has it."""
    return base64.urlsafe_b64encode(hashlib.sha256(path.read_bytes()).digest()).rstrip(b"=").decode()


if __name__ == "__main__":
    main(Path(sys.argv[1]))
