"""Benchmarks of the time-critical parts: `make bench` prints a table and writes `benchmarks/latest.json`.

Absolute times depend on the machine. Each time is therefore also given as a multiple of a fixed workload of numpy and
numba (`reference.py`), measured before and after the benchmark. `--compare FILE` sets the rows beside those of another
run, by these multiples.
"""

import argparse
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.table import Column, Table

from benchmarks import (
    bench_city,
    bench_fit,
    bench_loop,
    bench_overhead,
    bench_scaling,
    bench_sensor,
    bench_sweep,
    bench_tracker,
    bench_traffic,
)
from benchmarks.reference import reference_ms

OUT = Path(__file__).parent / "latest.json"
BENCHES = (
    bench_sensor, bench_fit, bench_tracker, bench_traffic, bench_loop, bench_scaling, bench_city, bench_sweep,
    bench_overhead,
)  # fmt: skip
MS = {"us": 1e-3, "ms": 1.0, "s": 1e3}
"""Milliseconds per unit of time."""

Row = dict[str, Any]


def main() -> None:
    """Run every benchmark, then print and write the rows."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks", description="Measure the time-critical parts.")
    parser.add_argument("--compare", type=Path, metavar="FILE", help="rows of another run, as written by this command")
    options = parser.parse_args()
    before = _rows_of(options.compare) if options.compare else {}
    rows = measure()
    OUT.write_text(json.dumps(rows, indent=2) + "\n")
    console = Console()
    console.print(table_of(rows))
    if before:
        console.print(comparison(before, rows))


def measure() -> dict[str, Row]:
    """Return the rows of all benchmarks; times have their multiple of the reference workload."""
    rows: dict[str, Row] = {}
    for bench in BENCHES:
        reference = reference_ms()
        found = bench.rows()
        reference = (reference + reference_ms()) / 2.0
        for row in found.values():
            row["multiple"] = row["value"] * MS[row["unit"]] / reference if row["unit"] in MS else None
        rows.update(found)
    return rows


def table_of(rows: Mapping[str, Row]) -> Table:
    """Return the table of one run."""
    table = Table(
        Column("benchmark", no_wrap=True),
        Column("value", justify="right"),
        "unit",
        Column("x reference", justify="right"),
        Column("ratio", justify="right"),
        Column("peer", overflow="fold"),
        title="luxloop, compiled kernels, one core except with two workers",
    )
    for name, row in rows.items():
        table.add_row(
            name, f"{row['value']:.3g}", row["unit"], _figure(row["multiple"]), _figure(row["ratio"]), row["peer"] or ""
        )
    return table


def comparison(before: Mapping[str, Row], rows: Mapping[str, Row]) -> Table:
    """Return the table of times before and now, as multiples of the reference workload, and how often faster."""
    numbers = [Column(title, justify="right") for title in ("before", "now", "times as fast")]
    table = Table(Column("benchmark", no_wrap=True), *numbers, title="times as multiples of the reference workload")
    for name, row in rows.items():
        old = before.get(name, {}).get("multiple")
        if old is not None and row["multiple"] is not None:
            table.add_row(name, _figure(old), _figure(row["multiple"]), _figure(old / row["multiple"]))
    return table


def _figure(value: float | None) -> str:
    return "" if value is None else f"{value:.3g}"


def _rows_of(file: Path) -> dict[str, Row]:
    """Return the rows of a file, or end with one line."""
    try:
        rows: dict[str, Row] = json.loads(file.read_text())
        if not all("multiple" in row for row in rows.values()):
            raise ValueError("its rows have no multiples of the reference workload")
    except (OSError, ValueError, AttributeError, TypeError) as error:
        raise SystemExit(f"{file}: {error}; give a file written by `python -m benchmarks`") from None
    return rows


if __name__ == "__main__":
    main()
