"""The page on statistics: its tables, its inputs, and the coverage of every kind of interval of a study."""

import re

import numpy as np
import pandas as pd
import pytest
from blocks import coverage
from intervals.seed_coverage import COLUMNS, FOLDER, collect, of_intervals, populations, seed_coverage
from support.pages import block
from support.paths import DOCS

PAGE = DOCS / "statistics.md"


def test_coverage_of_two_intervals_by_hand():
    found = of_intervals(1.0, [(0.0, 2.0), (1.5, 2.0), (1.0, 1.0), (0.5, 1.5)])
    assert (found.share, found.width) == (0.75, 0.75)


def test_tables_are_made_from_the_committed_figures():
    for name in ("seeds", "differences"):
        tables = (coverage.table(name, draws=10), block(PAGE, name))
        ours, theirs = ([line.split(" | ")[:2] for line in text.splitlines()] for text in tables)
        assert ours == theirs  # the same figures, with the same truth


def test_every_interval_of_a_study_covers_at_least_nine_in_ten():
    for one in populations():
        found = seed_coverage(one, 8, 1000)
        assert found.share >= 0.9, one
        common = one.values.value_counts(normalize=True).max()
        assert found.share <= 0.98 or common > 0.5, one  # most seeds are equal


def test_the_committed_table_is_within_the_target():
    shown = block(PAGE, "seeds")
    shares = [float(share) for share in re.findall(r"\| ([\d.]+) %", shown)]
    assert len(shares) == 3 * (len(shown.splitlines()) - 2)
    assert min(shares) >= 90.0


def test_figures_are_collected_from_sweeps(tmp_path, monkeypatch):
    for sweep, columns in COLUMNS.items():
        (tmp_path / sweep).mkdir()
        rows = pd.DataFrame({"seed": [1, 2], **{name: [0.123456, np.nan] for name in columns}})
        rows.to_parquet(tmp_path / sweep / "runs.parquet")
    monkeypatch.setattr("intervals.seed_coverage.FOLDER", tmp_path)
    collect(tmp_path)
    assert pd.read_csv(tmp_path / "hidden.csv")["track.hota"].tolist() == pytest.approx([0.1235, np.nan], nan_ok=True)


def test_the_studies_of_the_inputs_are_valid():
    from luxloop.scenarios.study.study_file import Study

    for sweep in COLUMNS:
        assert Study.load(FOLDER / f"{sweep}.toml").seed_list[0] == 1
