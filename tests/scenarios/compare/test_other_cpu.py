"""Runs whose last bits differ, as by the C library of an older processor: a comparison keeps its power."""

import os
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest
from support import recorded
from support.older_processor import OLDER_PROCESSOR
from support.paths import ROOT

from luxloop.scenarios.cli import main
from luxloop.scenarios.compare import run_pairs
from luxloop.scenarios.compare.comparison import compare
from luxloop.scenarios.compare.digest import digest
from luxloop.scenarios.compare.run_pairs import pair
from luxloop.scenarios.compare.vehicle_sums import TRUTH, close, counterparts
from luxloop.scenarios.run import run_folder


def run_scenario(out, environment, scenario="ring"):
    command = [sys.executable, "-m", "luxloop", "run", scenario, "--duration", "2", "--no-recording", "--out", str(out)]
    subprocess.run(command, env={**os.environ, **environment}, cwd=ROOT, check=False, stdout=subprocess.DEVNULL)


@pytest.fixture(scope="module")
def two_machines(tmp_path_factory):
    folder = tmp_path_factory.mktemp("machines")
    run_scenario(folder / "this", {})
    run_scenario(folder / "other", OLDER_PROCESSOR)
    assert main(["baseline", str(folder / "other"), "--out", str(folder / "other.jsonl")]) == 0
    return folder


@pytest.mark.slow
def test_run_of_another_instruction_set_is_the_same(two_machines, capsys):
    """Powers of the C library may differ without fused multiplications; the comparison is exact then, too."""
    pairs = pair(run_pairs.read_side(two_machines / "other.jsonl"), run_pairs.read_side(two_machines / "this"))
    assert pairs.notes == []
    assert pairs.compared[0].same
    assert len(pairs.compared[0].units()[0]) == 8  # seven vehicles and NO_ACTOR
    assert main(["compare", str(two_machines / "other.jsonl"), str(two_machines / "this")]) == 0
    assert "SAME: HEAD is as good as BASE; no metric is worse" in capsys.readouterr().out


@pytest.mark.slow
@pytest.mark.parametrize("scenario", ["sumo-crossing", "noise-all"])
def test_the_trace_is_the_same_bits_on_another_processor(scenario, tmp_path):
    """Traffic, every kind of noise, and the tracker."""
    for name, environment in {"this": {}, "other": OLDER_PROCESSOR}.items():
        run_scenario(tmp_path / name, environment, scenario)
    this, other = (run_folder.read(tmp_path / name) for name in ("this", "other"))
    assert this.frames > 20
    assert this.trace_hash == other.trace_hash


def test_truth_is_compared_within_tolerances():
    base = np.arange(3.0 * len(TRUTH)).reshape(3, -1) + 100.0
    head = base + 1e-11
    assert close(base, head).all()
    head[1, TRUTH.index("x_world_m")] += 2e-6
    ids = np.array([-1, 4, 7])
    assert [rows.tolist() for rows in counterparts(ids, ids, base, head)] == [[0, 2], [0, 2]]
    assert [rows.tolist() for rows in counterparts(ids, ids[1:], base, base[1:])] == [[1, 2], [0, 1]]


def last_bits_changed(run, rng):
    """Return the result of a run with lengths, angles and their rates changed by 1e-12 of their values."""
    tables = {}
    for name, table in run.result.tables.items():
        floats = [name for name in table.select_dtypes("float64") if name.endswith(("_m", "_deg", "_rad", "ps", "ps2"))]
        factor = 1.0 + 1e-12 * rng.standard_normal((len(table), len(floats)))
        tables[name] = table.assign(**(table[floats] * factor))
    return replace(run.result, trace_hash="other", tables=tables)


def test_planted_loss_of_two_percent_is_found_against_a_baseline_of_another_cpu():
    rng = np.random.default_rng(4)
    base = [digest(last_bits_changed(run, rng)) for run in recorded.runs()]
    head = [run.with_tracks(recorded.withhold(3, share=0.02), "withheld") for run in recorded.runs()]

    def against(runs):
        side = {run.key: run for run in runs}
        return compare(pair(run_pairs.Side(ROOT, {run.key: run for run in base}, []), run_pairs.Side(ROOT, side, [])))

    assert against(recorded.base()).verdict == "same"
    assert all(pair.same and not pair.identical for pair in against(recorded.base()).pairs.compared)
    assert against(head).verdict == "worse"


@pytest.mark.slow
def test_weights_of_the_truth_layer_are_the_same_bits():
    """A last bit of them became 0.3 mm in the path of a motorcycle, since the truth layer decides by limits."""
    program = (
        "from luxloop.sim.physical.spline import acceleration_weights, velocity_weights\n"
        "for half in range(1, 12):\n"
        "    for dt in (0.02, 0.04, 0.08, 0.1):\n"
        "        print(velocity_weights(half, dt).tobytes().hex(), acceleration_weights(half, dt).tobytes().hex())"
    )
    outputs = {
        subprocess.check_output([sys.executable, "-c", program], env={**os.environ, **environment}, cwd=ROOT)
        for environment in ({}, OLDER_PROCESSOR, {"OPENBLAS_CORETYPE": "Haswell"})
    }
    assert len(outputs) == 1
