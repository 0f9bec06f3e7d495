"""Mutations of tables for Parquet files: columns of other types and values, and tables of other shapes."""

import datetime
import decimal
import random
from io import BytesIO

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

FLOATS = (0.0, -1.0, np.nan, np.inf, -np.inf, 1e308, -1e308, 1e-308, 3e8, 1e18, 2.0**63, 0.5)
BOMB_ROWS = 20_000_000
GROUP_ROWS = 1_000_000


def parquet(table: pa.Table) -> bytes:
    """Return a table as a Parquet file."""
    stream = BytesIO()
    pq.write_table(table, stream)
    return stream.getvalue()


def mutated_table(rng: random.Random, table: pa.Table) -> tuple[bytes, str]:
    """Return a Parquet file with one to three mutations of a table, and their names."""
    names = []
    for way in rng.choices(WAYS, k=rng.choice((1, 1, 1, 2, 3))):
        if table.num_columns:
            table = way(rng, table)
        names.append(way.__name__.strip("_"))
    return parquet(table), " ".join(names)


def bomb(table: pa.Table) -> bytes:
    """Return a small file of 20 million equal rows."""
    rows = {name: pa.repeat(table[name][0], GROUP_ROWS) for name in table.column_names}
    stream, group = BytesIO(), pa.table(rows)
    with pq.ParquetWriter(stream, group.schema, compression="zstd") as writer:
        for _ in range(BOMB_ROWS // GROUP_ROWS):
            writer.write_table(group)
    return stream.getvalue()


def _value(rng, table):
    """Replace a cell, or all cells of a column, by a number that is no good."""
    name = rng.choice(table.column_names)
    try:
        values = np.array(_cells(table, name).to_pylist(), dtype=np.float64)
    except (TypeError, ValueError):
        values = np.zeros(table.num_rows)
    rows = slice(None) if rng.random() < 0.3 or not len(values) else rng.randrange(len(values))
    values[rows] = rng.choice(FLOATS)
    return _with(table, name, pa.array(values))


def _type(rng, table):
    """Replace a column by one of another type."""
    name, count = rng.choice(table.column_names), table.num_rows
    made = [
        lambda: pa.array([[1.0, 2.0]] * count),
        lambda: pa.array([[]] * count, pa.list_(pa.float64())),
        lambda: pa.array([{"a": 1}] * count),
        lambda: pa.array([True] * count),
        lambda: pa.array([datetime.date(2020, 1, 1)] * count),
        lambda: pa.array([datetime.datetime(9999, 1, 1)] * count),
        lambda: pa.array([datetime.timedelta(1)] * count),
        lambda: pa.array([datetime.time(1)] * count),
        lambda: pa.array([decimal.Decimal("1e30")] * count),
        lambda: pa.array([str(rng.choice(FLOATS))] * count),
        lambda: pa.array(["9" * 400] * count),
        lambda: pa.array(["\x1b[31m\0"] * count),
        lambda: pa.array([b"\xff\xfe"] * count),
        lambda: pa.nulls(count),
        lambda: pa.array([None] * count, pa.float64()),
        lambda: pa.array(["a"] * count).dictionary_encode(),
        lambda: pa.array([1.5] * count).dictionary_encode(),
        lambda: pa.array([2**64 - 1] * count, pa.uint64()),
        lambda: pa.array([-(2**63)] * count, pa.int64()),
        lambda: pa.array(np.ones(count, np.float16)),
        lambda: pa.array([[("k", 1)]] * count, pa.map_(pa.string(), pa.int64())),
        lambda: pa.array([[1.0]] * count, pa.list_(pa.float64(), 1)),
    ]
    return _with(table, name, rng.choice(made)())


def _cast(rng, table):
    """Give a column in another type of number, or as text."""
    name = rng.choice(table.column_names)
    wanted = rng.choice((pa.float32(), pa.float16(), pa.int8(), pa.int64(), pa.string(), pa.large_string(), pa.bool_()))
    try:
        return _with(table, name, _cells(table, name).cast(wanted, safe=False))
    except pa.ArrowException:
        return _type(rng, table)


def _null(rng, table):
    """Empty some cells."""
    name = rng.choice(table.column_names)
    values = [None if rng.random() < 0.5 else value for value in _cells(table, name).to_pylist()]
    return _with(table, name, pa.array(values, _cells(table, name).type))


def _drop(rng, table):
    return table.remove_column(rng.randrange(table.num_columns))


def _rename(rng, table):
    at, name = rng.randrange(table.num_columns), rng.choice(["", "x", "\x1b[31m", *table.column_names])
    return table.rename_columns([name if place == at else old for place, old in enumerate(table.column_names)])


def _rows(rng, table):
    """Take no row, one row, some rows, or rows twice."""
    count = table.num_rows
    if not count or rng.random() < 0.3:
        return table.slice(0, rng.choice((0, 0, 1)))
    return table.take([rng.randrange(count) for _ in range(rng.choice((1, 2, count, 2 * count)))])


def _cells(table, name):
    return table.column(table.column_names.index(name))


def _with(table, name, column):
    place = table.column_names.index(name)
    return table.set_column(place, name, column)


WAYS = (_value, _value, _value, _value, _type, _type, _type, _cast, _null, _drop, _rename, _rows)
