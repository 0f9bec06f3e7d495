"""A metric that is added to the list of definitions, and nowhere else, appears wherever metrics do."""

import json
import subprocess
import sys

import pytest
from support import short_run

ADDED = """
import json, sys
from luxloop.scenarios.metrics import definitions
from luxloop.scenarios.metrics.definition import OF_VEHICLES, MetricDefinition, Relevance

definitions.DEFINITIONS["track.far_off"] = MetricDefinition(
    "track.far_off", "m", "mean distance of the centres of moving vehicles", "track", "position_error_m", "moving",
    filters=OF_VEHICLES, compared=Relevance(0.01, 0.01),
)

from luxloop.scenarios.cli import main
from luxloop.scenarios.study import row_store

assert "track.far_off" in row_store.METRICS
codes = [main(words) for words in json.loads(sys.argv[1])]
assert codes == [0] * len(codes), codes
"""
EXPECT = """
[expect]
"track.far_off" = { max = 5.0 }
"track.far_off{class=car}" = { max = 5.0 }
"""


@pytest.mark.slow
def test_an_added_metric_is_in_reports_expectations_comparisons_studies_and_gradings_of_files(tmp_path):
    path = short_run.write(tmp_path, short_run.TEXT.partition("[expect]")[0] + EXPECT)
    run = str(tmp_path / "a")
    words = [
        ["run", str(path), "--out", run, "--no-recording", "--record-scans", "--json"],
        ["report", run],
        ["compare", run, run, "--json"],
        ["grade", "--truth", f"{run}/scans/labels.parquet", "--tracks", f"{run}/tables/tracks.parquet"],
    ]
    command = [sys.executable, "-c", ADDED, json.dumps(words)]
    out = subprocess.run(command, capture_output=True, text=True, check=False, cwd=tmp_path)
    assert out.returncode == 0, out.stderr
    result, comparison = [json.loads(line) for line in out.stdout.splitlines() if line.startswith("{")]
    assert "track.far_off" in comparison["metrics"]
    assert result["metrics"]["track.far_off"]["value"] > 0.0
    assert result["metrics"]["track.far_off{class=car}"]["value"] > 0.0
    assert result["verdict"] == "passed"
    assert "track.far_off" in (tmp_path / "a" / "report.txt").read_text(encoding="utf-8")
    assert "track.far_off" in (tmp_path / "a.html").read_text(encoding="utf-8")
    assert [line for line in out.stdout.splitlines() if line.startswith("track.far_off ")]  # in the grading of files
