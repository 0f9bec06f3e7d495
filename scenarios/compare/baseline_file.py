"""Baseline file: reference runs of a comparison in one file, small enough to be committed.

The format is JSON Lines: a header, then one line per run, sorted by scenario and seed. A diff of two versions of the
file thus names the changed runs. Equal runs give equal bytes.
"""

import json
from collections.abc import Iterable
from dataclasses import asdict, fields
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import TypeAdapter, ValidationError

from luxloop.arrays import Floats
from luxloop.scenarios.compare.digest import RunDigest, RunFacts
from luxloop.scenarios.compare.vehicle_sums import SUMS, TRUTH, VehicleSums
from luxloop.scenarios.errors import OutputError
from luxloop.scenarios.files import atomic_file
from luxloop.scenarios.files.input_file import require_plain
from luxloop.scenarios.grading.tracking_scores import ALPHAS

FORMAT = 2
"""Format version; increased by incompatible changes."""
HEADER = {"luxloop_baseline": FORMAT, "sums": ["vehicle", *SUMS], "truth": [*TRUTH]}

LARGEST = 1e12
"""Absolute value of any figure, in any unit."""
REMEDY = "write the file again with luxloop baseline"


FACTS = TypeAdapter(RunFacts)


def write(path: Path, runs: list[RunDigest]) -> None:
    """Write a baseline file atomically.

    Raises
    ------
    OutputError
        The file cannot be written.
    """
    documents = [HEADER, *(_document(run) for run in sorted(runs, key=lambda run: run.key))]
    lines = [json.dumps(document, separators=(",", ":"), ensure_ascii=False, allow_nan=False) for document in documents]
    atomic_file.save_text(path, "\n".join(lines) + "\n")


def read(path: Path) -> list[RunDigest]:
    """Read a baseline file.

    Raises
    ------
    OutputError
        The file is missing, damaged, or of another format version.
    """
    require_plain(path)
    try:
        header, *documents = (json.loads(line) for line in path.read_text(encoding="utf-8").splitlines())
    except OSError as error:
        raise OutputError(f"{path}: {error.strerror}; give a folder of runs or a baseline file") from error
    except (ValueError, RecursionError) as error:
        raise OutputError(f"{path}: not a baseline file ({error}); {REMEDY}") from error
    if header != HEADER:
        raise OutputError(f"{path}: not a baseline file of this version; {REMEDY}")
    runs = []
    for number, document in enumerate(documents, start=2):
        try:
            runs.append(_run(document))
        except (KeyError, TypeError, ValueError, IndexError, AttributeError, OverflowError) as error:
            raise OutputError(f"{path}: line {number} is not a run ({error!r}); {REMEDY}") from error
    return runs


def _document(run: RunDigest) -> dict[str, Any]:
    document = asdict(run)
    vehicles = document.pop("vehicles")
    sums = [
        [vehicle, *map(_compact, row)]
        for vehicle, row in zip(vehicles["vehicle"].tolist(), vehicles["sums"].tolist(), strict=True)
    ]
    truth = [[*map(_compact, row)] for row in vehicles["truth"].tolist()]
    return {**document, "sums": sums, "matches": vehicles["matches"].tolist(), "truth": truth}


def _require_plausible(figures: Iterable[Floats | float]) -> None:
    """Raise a ValueError for a figure that is not finite or that no run has."""
    for figure in figures:
        if not np.all(np.abs(figure) <= LARGEST):
            raise ValueError(f"a figure is not a number within {LARGEST:g}")


def _compact(value: float) -> float:
    """Return whole numbers, the most frequent sums, as integers."""
    return int(value) if value.is_integer() else value


def _run(document: dict[str, Any]) -> RunDigest:
    try:
        facts = FACTS.validate_python(document)
    except ValidationError as error:
        (first, *_) = error.errors()
        raise ValueError(f"{'.'.join(map(str, first['loc']))}: {first['msg']}") from error
    sums = np.array(document["sums"], dtype=np.float64).reshape(-1, 1 + len(SUMS))
    matches = np.array(document["matches"], dtype=np.int64).reshape(-1, 2 + len(ALPHAS))
    truth = np.array(document["truth"], dtype=np.float64).reshape(len(sums), len(TRUTH))
    _require_plausible([sums, truth, *(entry.value or 0.0 for entry in facts.expectations.values())])
    return RunDigest(
        **{field.name: getattr(facts, field.name) for field in fields(RunFacts)},
        vehicles=VehicleSums(sums[:, 0].astype(np.int64), sums[:, 1:], matches, truth),
    )
