"""The same bits with the programs that libraries run on other processors."""

import json
import os
import subprocess
import sys

import pytest
from support.older_processor import OLDER_PROCESSOR
from support.paths import EXAMPLES

pytestmark = pytest.mark.slow


@pytest.mark.parametrize("scenario", [str(EXAMPLES / "my-first.toml"), "highway-v0", "crossing-in-rain"])
def test_a_run_has_the_same_trace_hash(scenario, tmp_path):
    """A product by a library, or a function of numpy, in the path of a record gives another hash."""
    hashes = set()
    for name, variables in (("here", {}), ("older", OLDER_PROCESSOR)):
        command = [sys.executable, "-m", "luxloop", "run", scenario, "--no-recording", "--set", "duration_s=6"]
        run = subprocess.run(
            [*command, "--out", str(tmp_path / name)], env={**os.environ, **variables}, capture_output=True, text=True
        )
        assert run.returncode in (0, 1), run.stderr  # limits of a shortened drive may fail
        hashes.add(json.loads((tmp_path / name / "result.json").read_text(encoding="utf-8"))["trace_hash"])
    assert len(hashes) == 1
