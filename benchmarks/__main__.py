"""Benchmarks of the time-critical parts: `make bench` prints a table and writes `benchmarks/latest.json`.

Absolute times depend on the machine: compare medians, and ratios to a peer measured in the same run.
"""

import json
from pathlib import Path

from rich.console import Console
from rich.table import Table

from benchmarks import bench_fit, bench_loop, bench_overhead, bench_sensor, bench_sweep, bench_tracker, bench_traffic

OUT = Path(__file__).parent / "latest.json"


def main() -> None:
    """Run every benchmark, then print and write the rows."""
    rows = {}
    for bench in (bench_sensor, bench_fit, bench_tracker, bench_traffic, bench_loop, bench_sweep, bench_overhead):
        rows.update(bench.rows())
    OUT.write_text(json.dumps(rows, indent=2) + "\n")
    table = Table(
        "benchmark",
        "value",
        "unit",
        "peer",
        "ratio",
        title="luxloop, compiled kernels, one core except with two workers",
    )
    for name, row in rows.items():
        ratio = "" if row["ratio"] is None else f"{row['ratio']:.2f}"
        table.add_row(name, f"{row['value']:.3g}", row["unit"], row["peer"] or "", ratio)
    Console().print(table)


if __name__ == "__main__":
    main()
