"""Terminal, page, Markdown, JSON and exit code of one comparison give one answer, for every verdict."""

import json
import math
import re
from dataclasses import replace
from html import unescape
from pathlib import Path

import numpy as np
import pytest
from support import recorded
from support.few import few

from luxloop.scenarios.cli import main
from luxloop.scenarios.compare import baseline_file
from luxloop.scenarios.compare.comparison import compare
from luxloop.scenarios.compare.comparison_answer import SeedsNeeded, answer, needed_text, seeds_needed
from luxloop.scenarios.compare.digest import Expectation
from luxloop.scenarios.compare.run_pairs import Side, pair
from luxloop.scenarios.compare.vehicle_sums import SUMS

MET, MISSED = (Expectation(outcome, value, ">= 0.9") for outcome, value in (("passed", 0.9), ("failed", 0.89)))


def scaled(run, factors):
    sums = run.vehicles.sums.copy()
    for column, factor in factors.items():
        sums[:, SUMS.index(column)] *= factor
    return replace(run, trace_hash="scaled", vehicles=replace(run.vehicles, sums=sums))


def noisy(run, column, spread):
    """Multiply the sums of each vehicle by a random factor."""
    sums, rng = run.vehicles.sums.copy(), np.random.default_rng(1)
    sums[:, SUMS.index(column)] *= rng.uniform(1.0 - spread, 1.0 + spread, len(sums))
    return replace(run, trace_hash="noisy", vehicles=replace(run.vehicles, sums=sums))


def with_expectation(runs, expectation):
    first, *others = runs
    return [replace(first, expectations={"track.hota": expectation}), *others]


def cases():
    base = list(recorded.base())
    return {
        "worse": (base, [scaled(run, {"hits": 0.9}) for run in base], "worse", 1, "HEAD misses more vehicles"),
        "better": (base, [scaled(run, {"fit_heading_deg": 0.9}) for run in base], "better", 0, "fits headings better"),
        "same": (base, base, "same", 0, "HEAD is as good as BASE"),
        "cannot tell": (base, [noisy(run, "fit_heading_deg", 0.4) for run in base], "cannot tell", 5, "cannot tell"),
        "newly failed": (
            *(with_expectation(base, one) for one in (MET, MISSED)),
            "worse",
            1,
            "HEAD is worse than BASE: 1 expectation newly fails",
        ),
    }


@pytest.mark.parametrize("case", few(["worse", "better", "same", "cannot tell", "newly failed"], "worse", "same"))
def test_all_five_say_the_same(case, tmp_path, capsys):
    base, head, verdict, code, said = cases()[case]
    files = [str(tmp_path / f"{name}.jsonl") for name in ("base", "head")]
    for file, runs in zip(files, (base, head), strict=True):
        baseline_file.write(Path(file), runs)
    assert main(["compare", *files, "--report", str(tmp_path / "out")]) == code
    printed = capsys.readouterr().out
    assert main(["compare", *files, "--json"]) == code
    document = json.loads(capsys.readouterr().out)
    sentence = document["answer"]
    assert document["verdict"] == verdict
    assert said in sentence
    assert " ".join(printed.split()).startswith(f"{verdict.upper()}: {sentence}")
    lines = (tmp_path / "out" / "comparison.md").read_text(encoding="utf-8").splitlines()
    assert lines[0].endswith(f": {verdict}")
    assert lines[2].replace("\\", "") == f"**{sentence}.**"
    page = (tmp_path / "out" / "comparison.html").read_text(encoding="utf-8")
    header = unescape(re.sub("<[^>]*>", "", page[page.index("<header>") : page.index("<figure")]))
    assert " ".join(header.split()) == f"Comparison of two versions {verdict} {sentence}."


def compared(base, head, loss=0.02):
    sides = (Side(Path("x"), {run.key: run for run in runs}, []) for runs in (base, head))
    return compare(pair(*sides), loss)


def test_the_seeds_needed_follow_from_interval_and_limit():
    """By hand: n (half / distance)^2 of the most uncertain metric, rounded up."""
    head = [noisy(run, "fit_heading_deg", 0.4) for run in recorded.base()]
    comparison = compared(list(recorded.base()), head, 0.15)
    unclear = [change for change in comparison.changes if change.verdict == "unclear"]
    found = seeds_needed(comparison)
    (change,) = unclear
    low, high = change.numbers.interval
    limit = comparison.loss * change.numbers.base
    distance = limit - change.numbers.difference
    assert found.needed == math.ceil(found.now * (0.5 * (high - low) / distance) ** 2) > found.now
    assert f"about {found.needed} seeds of each scenario would be needed" in answer(comparison).sentence


def test_it_says_when_no_number_of_seeds_can_be_named():
    assert "more seeds would not exclude it if a is as much worse" in needed_text(SeedsNeeded(3, None, unbounded="a"))
    assert "a has too few vehicles to say" in needed_text(SeedsNeeded(3, None, without_interval="a"))
