"""The folder of a run, written atomically. A run that ended early is marked in `result.json`.

- `result.json`: metrics, verdict, trace hash, effective config, versions
- `report.txt`: the printed report
- `tables/*.parquet`: per-frame tables
- `recording.rrd`: for `luxloop view`, unless switched off
- `scans/`: a data set, see `luxloop.scenarios.dataset.writer`, if asked for
"""

import json
from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager
from dataclasses import asdict
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from luxloop.scenarios.dataset import writer as dataset
from luxloop.scenarios.errors import OutputError
from luxloop.scenarios.files import atomic_file, atomic_folder
from luxloop.scenarios.files.expect import Check, verdict
from luxloop.scenarios.files.input_file import read_parquet
from luxloop.scenarios.grading.figures import Figures
from luxloop.scenarios.grading.frame_tables import SCHEMAS
from luxloop.scenarios.grading.grading_config import GradingConfig
from luxloop.scenarios.grading.observations import RunObservations
from luxloop.scenarios.metrics import of_files, of_recordings
from luxloop.scenarios.metrics.definitions import is_metric
from luxloop.scenarios.metrics.own_metric import PREFIX
from luxloop.scenarios.result import Metric, Result

RESULT = "result.json"
REPORT = "report.txt"
RECORDING = "recording.rrd"
TABLES = "tables"
SCANS = "scans"
REASONS = ("reason", "why_no_interval")
"""Keys of a metric that are often empty."""


def create(out: Path) -> AbstractContextManager[Path]:
    """Yield a temporary folder that becomes `out` at the end and replaces an earlier run there.

    Raises
    ------
    OutputError
        `out` cannot be written, or holds something else than an earlier run.
    """
    contents = (RESULT, REPORT, RECORDING, TABLES, SCANS)
    refuse = partial(atomic_folder.refuse_other_files, marks=[RESULT], contents=contents, what="a run")
    return atomic_folder.create(out, "--out", refuse)


@contextmanager
def scans(folder: Path) -> Iterator[dataset.DatasetWriter]:
    """Yield a writer of the run's scans; `folder` is the temporary folder.

    Raises
    ------
    OutputError
        The folder cannot be written, for instance because the disk is full.
    """
    with atomic_file.writing(folder):
        (folder / SCANS).mkdir()
    with dataset.write_into(folder / SCANS, "--out") as writer:
        yield writer


def document(result: Result, checks: list[Check]) -> dict[str, Any]:
    """Return a result without its tables, for JSON; a metric that does not apply is null, with the reason."""
    return {
        "scenario": result.scenario,
        "seed": result.seed,
        "trace_hash": result.trace_hash,
        "verdict": verdict(checks, result.complete),
        "failed": [check.name for check in checks if check.outcome == "failed"],
        "known_failures": [check.name for check in checks if check.outcome == "known failure"],
        "not_applicable": [check.name for check in checks if check.outcome == "not applicable"],
        "unexpected_passes": [check.name for check in checks if check.outcome == "unexpected pass"],
        "complete": result.complete,
        "ended_early": result.ended_early,
        "simulator_failed": result.simulator_failed,
        "frames": result.frames,
        "warnings": list(result.warnings),
        "metrics": {name: metric_document(metric) for name, metric in result.metrics.items()},
        "config": result.config,
        "versions": result.versions,
    }


def write(folder: Path, result: Result, checks: list[Check], report: str) -> None:
    """Write all files except the recording.

    Raises
    ------
    OutputError
        The folder cannot be written, for instance because the disk is full.
    """
    with atomic_file.writing(folder):
        text = json.dumps(document(result, checks), indent=2, ensure_ascii=False, allow_nan=False)
        (folder / REPORT).write_text(report, encoding="utf-8")
        (folder / TABLES).mkdir()
        for name, table in result.tables.items():
            table.to_parquet(folder / TABLES / f"{name}.parquet", index=False)
        (folder / RESULT).write_text(text + "\n", encoding="utf-8")  # last: marks the folder as complete


def read(folder: Path) -> Result:
    """Read a run back.

    Raises
    ------
    OutputError
        The folder holds no run, an incomplete one, or a damaged one.
    """
    if atomic_folder.is_unfinished(folder):
        raise OutputError(f"{folder}: incomplete: the run was killed; run the scenario again")
    try:
        document = json.loads((folder / RESULT).read_text(encoding="utf-8"))
        _require_document(document)
        tables = {path.stem: _read_table(path) for path in sorted((folder / TABLES).glob("*.parquet"))}
        return Result(
            scenario=_name(document["scenario"]),
            seed=document["seed"],
            trace_hash=document["trace_hash"],
            ended_early=document["ended_early"],
            simulator_failed=document["simulator_failed"],
            frames=document["frames"],
            metrics=_figures(document, tables),
            tables=tables,
            config=document["config"],
            versions=document["versions"],
            warnings=tuple(map(str, document["warnings"])),
            out=folder,
        )
    except (FileNotFoundError, NotADirectoryError) as error:
        raise _not_a_run(folder) from error
    except (OSError, ValueError, LookupError, TypeError, AttributeError, RecursionError) as error:
        # Malformed JSON and Parquet raise a ValueError.
        why = "the run in it is damaged, or of another version of luxloop; run the scenario again"
        raise OutputError(f"{folder}: {why}") from error


def found_in(folder: Path) -> list[Path]:
    """Return all run folders at and below `folder`, sorted by path, without the temporary folders of killed runs."""
    found = sorted(path.parent for path in folder.rglob(RESULT))
    return [run for run in found if not any(part.startswith(".") for part in run.relative_to(folder).parts)]


def recording(folder: Path) -> Path:
    """Path of a run's recording.

    Raises
    ------
    OutputError
        The run has none, or the folder holds no run.
    """
    if not (folder / RESULT).is_file():
        raise _not_a_run(folder)
    path = folder / RECORDING
    if not path.is_file():
        raise OutputError(f"{folder}: no {RECORDING} in it; run the scenario again without --no-recording")
    return path


def _not_a_run(folder: Path) -> OutputError:
    fault = "is a file" if folder.is_file() else f"no {RESULT} of a run in it"
    return OutputError(f"{folder}: {fault}; give a folder that luxloop run wrote")


def metric_document(metric: Metric) -> dict[str, Any]:
    """Return the JSON of a metric; reasons are left out if they are empty."""
    return {key: value for key, value in asdict(metric).items() if key not in REASONS or value}


def _require_document(document: dict[str, Any]) -> None:
    """Check that a result has finite numbers and known metrics.

    Raises
    ------
    ValueError
        It has not.
    """
    json.dumps(document, allow_nan=False)  # JSON has numbers, as 1e999, that become infinite
    for name in document["metrics"]:
        if not (name.startswith(PREFIX) or is_metric(name)):
            raise ValueError(f"{name} is no metric")


def _name(scenario: str) -> str:
    """Return the name of a scenario, by which exporters and figures name files of their folders."""
    if Path(scenario).name != scenario or scenario == ".." or "\0" in scenario:
        raise ValueError(f"{scenario!r} is no name of a scenario")
    return scenario


def _figures(document: dict[str, Any], tables: dict[str, pd.DataFrame]) -> Figures:
    """Return the figures of a run; those that its file does not hold are computed from its tables."""
    known = {name: _read_metric(metric) for name, metric in document["metrics"].items()}
    config = document["config"]
    run = RunObservations(tables, GradingConfig(**config["grading"]), document["frames"])
    if "files" in config:
        return Figures(run, known, of_files.why_not(config["missing"]), of_files.NAMES)
    recording = config.get("recording")
    return Figures(run, known, None if recording is None else of_recordings.why_not(bool(recording.get("truth"))))


def _read_metric(document: dict[str, Any]) -> Metric:
    interval = document.get("interval")
    return Metric(**{**document, "interval": tuple(interval) if interval else None})


def _read_table(path: Path) -> pd.DataFrame:
    table = read_parquet(path).to_pandas()
    require_table(path.stem, table)
    return table


LARGEST_NUMBER = 1e12
"""Absolute value of any finite number, in any unit."""
FINITE_TABLES = ("truth",)
"""Tables without infinite numbers."""
KEYS = {
    "truth": ["frame", "actor_id"],
    "tracks": ["frame", "track_id"],
    "fits": ["frame", "actor_id", "method"],
}
"""Columns whose values together name one row of a table."""
MEASURED = {"fits": ("heading_error_deg", "position_error_m", "oracle")}
"""Columns that grading adds to those of the schema, and that pages need."""
DTYPE_KINDS = {np.int64: "iu", np.float64: "fiu", np.bool_: "b"}
"""Kinds of dtype by the type of a column."""


def require_table(name: str, table: pd.DataFrame) -> None:
    """Check types and magnitudes of the columns of a table.

    Raises
    ------
    ValueError
        A column is missing or has another type, a number is one that no run has, or a row occurs twice.
    """
    schema = SCHEMAS.get(name, {})
    known = {"frame", *schema, *MEASURED.get(name, ())} if schema else set()
    if missing := sorted(known - set(table.columns)):
        raise ValueError(f"column {missing[0]} of {name} is missing")
    if not table.columns.is_unique:
        raise ValueError(f"a column of {name} occurs twice")
    for name_of_column, cells in table.items():
        column = str(name_of_column)
        wanted = schema.get(column)
        plain = pd.api.types.is_numeric_dtype(cells) or isinstance(cells.dtype, pd.CategoricalDtype)
        if not (plain or pd.api.types.is_string_dtype(cells)):
            raise ValueError(f"column {column} of {name} holds {cells.dtype}")
        if (
            isinstance(wanted, type)
            and wanted in DTYPE_KINDS
            and getattr(cells.dtype, "kind", "O") not in DTYPE_KINDS[wanted]
        ):
            raise ValueError(f"column {column} of {name} holds {cells.dtype}, not {wanted.__name__}")
        if cells.dtype.kind in "fiu":
            _require_magnitude(name, column, cells.to_numpy(np.float64))
    if name in KEYS and table.duplicated(KEYS[name]).any():
        raise ValueError(f"two rows of {name} have the same {', '.join(KEYS[name])}")


def _require_magnitude(name: str, column: str, values: np.ndarray) -> None:
    wrong = np.abs(values) > LARGEST_NUMBER
    if name not in FINITE_TABLES:
        wrong &= np.isfinite(values)
    if wrong.any():
        raise ValueError(f"column {column} of {name}: {values[np.argmax(wrong)]:g} is no plausible number")
