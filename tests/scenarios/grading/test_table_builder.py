"""Tables collected frame by frame."""

import gc
import tracemalloc
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest

from luxloop.scenarios.grading.frame_tables import CHUNK_FRAMES, Schema, TableBuilder, rows_of_pairs

SCHEMA: Schema = {"name": np.str_, "x_m": np.float64, "kind": ("car", "bus")}


@pytest.mark.parametrize("frames", [0, 1, CHUNK_FRAMES, 2 * CHUNK_FRAMES + 3])
def test_a_table_has_the_rows_of_all_frames_in_order(frames):
    rng = np.random.default_rng(1)
    builder, expected = TableBuilder(SCHEMA), []
    for index in range(frames):
        rows = int(rng.integers(0, 4))
        columns = {
            "name": np.array([f"car{index}" * (1 + row) for row in range(rows)], np.str_),
            "x_m": rng.normal(size=rows),
            "kind": rng.integers(0, 2, rows),
        }
        builder.add(SimpleNamespace(index=index, time=0.08 * index), columns)
        expected += [
            (index, 0.08 * index, str(name), float(x), SCHEMA["kind"][kind])
            for name, x, kind in zip(*columns.values(), strict=True)
        ]
    table = builder.build()
    names = ["frame", "time_s", *SCHEMA]
    assert list(table.itertuples(index=False, name=None)) == expected
    assert list(table.columns) == names
    assert isinstance(table["kind"].dtype, pd.CategoricalDtype)


def test_a_column_that_is_missing_or_unknown_is_refused():
    with pytest.raises(ValueError, match="'x_m'"):
        TableBuilder(SCHEMA).add(SimpleNamespace(index=0, time=0.0), {"name": np.array(["a"]), "kind": np.array([0])})


def test_memory_does_not_grow_with_the_number_of_frames():
    """Kept in memory, the rows of the later frames would take 240 kB."""
    builder = TableBuilder(SCHEMA)
    columns = {"name": np.array(["car"] * 8), "x_m": np.zeros(8), "kind": np.zeros(8, np.int8)}
    held = []
    tracemalloc.start()
    try:
        for index in range(7 * CHUNK_FRAMES):
            builder.add(SimpleNamespace(index=index, time=0.08 * index), dict(columns))
            if index + 1 in (2 * CHUNK_FRAMES, 7 * CHUNK_FRAMES):
                gc.collect()
                held.append(tracemalloc.get_traced_memory()[0])
    finally:
        tracemalloc.stop()
    assert held[1] - held[0] < 10_000
    assert len(builder.build()) == 7 * CHUNK_FRAMES * 8


def test_pairs_are_found_at_their_first_row():
    """Ids that occur on one side only, unordered frames, pairs that occur twice, and frames shared by other ids."""
    rng = np.random.default_rng(1)
    frame, number = rng.integers(0, 5, 60), rng.choice([-1, 3, 4, 10**12], 60)
    of_frame, of_number = rng.integers(0, 5, 12), rng.choice([-1, 4, 7, 10**12], 12)
    others = list(zip(of_frame.tolist(), of_number.tolist(), strict=True))
    expected = [
        others.index(pair) if pair in others else -1 for pair in zip(frame.tolist(), number.tolist(), strict=True)
    ]
    assert -1 in expected
    assert len(set(others)) < len(others)
    assert rows_of_pairs(frame, number, of_frame, of_number).tolist() == expected
    assert rows_of_pairs(frame[:2], number[:2], of_frame[:0], of_number[:0]).tolist() == [-1, -1]
