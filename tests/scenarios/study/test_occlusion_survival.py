"""Regression of survival over the occlusions of several runs, and the command."""

import dataclasses
import json

import numpy as np
import pandas as pd
import pytest
from scipy.special import expit
from support import short_run

from luxloop.scenarios.cli import main
from luxloop.scenarios.run import run_folder
from luxloop.scenarios.study.occlusion_survival import clustered_share, regress

MIDDLE_S, STEEPNESS = 2.0, 4.0


def occlusions(rng, count=30):
    """Occlusions of a run, with half of the ids lost after 2 s."""
    gap = rng.uniform(0.2, 4.0, count)
    table = short_run.result().tables["occlusions"].iloc[:0]
    values = {
        "actor_id": np.arange(count),
        "hidden_s": gap,
        "survived": rng.random(count) < expit(STEEPNESS * (MIDDLE_S - gap)),
        "manoeuvre": np.where(np.arange(count) % 3, "keeps", "brakes"),
        "hidden_by_kind": "truck",
        "kind": "car",
    }
    unset = {name: "" if dtype == np.dtype("O") else 0 for name, dtype in table.dtypes.items()}
    return pd.DataFrame({**unset, **values}, columns=list(table.columns)).astype(table.dtypes)


@pytest.fixture(scope="module")
def runs(tmp_path_factory):
    """Twelve run folders with synthetic occlusions."""
    folder, rng = tmp_path_factory.mktemp("runs"), np.random.default_rng(2)
    for seed in range(1, 13):
        result = short_run.result()
        changed = dataclasses.replace(result, seed=seed, tables={**result.tables, "occlusions": occlusions(rng)})
        (folder / f"seed{seed}").mkdir()
        run_folder.write(folder / f"seed{seed}", changed, [], "")
    return folder


def test_the_command_finds_the_gaps_of_half_and_of_most_ids(runs, tmp_path, capsys):
    assert main(["occlusions", str(runs), "--json", "--out", str(tmp_path / "out")]) == 0
    found = json.loads(capsys.readouterr().out)
    assert (found["occlusions"], found["runs"], found["clusters"]) == (360, 12, "runs")
    half, most = found["thresholds"]
    assert (half["share"], most["share"]) == (0.5, 0.95)
    assert half["low"] < MIDDLE_S < half["high"]
    assert half["high"] - half["low"] < 0.4
    assert most["low"] < MIDDLE_S - np.log(19) / STEEPNESS < most["high"]
    groups = {row["level"]: row["occlusions"] for row in found["groups"]["manoeuvre"]}
    assert groups == {"keeps": 240, "brakes": 120}
    assert sorted(path.name for path in (tmp_path / "out").iterdir()) == [
        "occlusions.parquet", "survival.json", "survival.png"
    ]  # fmt: skip
    pooled = pd.read_parquet(tmp_path / "out" / "occlusions.parquet")
    assert (len(pooled), pooled["seed"].nunique()) == (360, 12)


def test_few_runs_are_resampled_by_vehicle_and_runs_given_twice_count_once(runs, capsys):
    assert main(["occlusions", str(runs / "seed1"), str(runs / "seed1"), "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert (found["occlusions"], found["clusters"]) == (30, "vehicles")


def test_a_threshold_beyond_the_observed_gaps_is_not_given():
    table = occlusions(np.random.default_rng(1), 40).assign(run="a", survived=True)
    value, (low, high) = regress(table).threshold(0.5)
    assert not 0.2 <= value <= 4.0
    assert low <= value <= high or not np.isfinite(high)


def test_repeated_outcomes_of_a_cluster_count_once():
    one = np.array([True] * 14 + [False] * 6)
    alone = clustered_share(one, np.arange(20))
    repeated = clustered_share(np.repeat(one, 10), np.repeat(np.arange(20), 10))
    assert alone[0] == repeated[0] == 0.7
    assert repeated[1] == pytest.approx(alone[1], abs=0.02)
    assert alone[1] == pytest.approx((0.457, 0.881), abs=0.02)  # Clopper and Pearson, 14 of 20
    assert clustered_share(np.ones(30, bool), np.repeat(np.arange(3), 10))[1][0] == pytest.approx(0.025 ** (1 / 3))


@pytest.mark.parametrize("case", ["no run", "one gap"])
def test_missing_occlusions_are_one_line(case, tmp_path, capsys):
    if case == "no run":
        folder, words = tmp_path, "no run in it"
    else:
        folder, words = tmp_path / "run", "too few for a curve"
        folder.mkdir()
        run_folder.write(folder, short_run.result(), [], "")
    assert main(["occlusions", str(folder)]) == 2
    message = capsys.readouterr().err
    assert words in message
    assert message.count("\n") == 1
