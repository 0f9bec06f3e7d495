"""Columns of the rows of a study, and the text of a row in the append log."""

import json
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any, Self

import pyarrow as pa

from luxloop.scenarios.grading.metric_names import METRICS
from luxloop.scenarios.grading.own_metric import PREFIX

RunRow = dict[str, Any]
"""`index`, `key`, `seed`, `tracker`, the parameters by their keys, `status`, `error`, `trace_hash`, `frames`, `wall_s`,
`why` the run was executed or its row taken over, the digests of its `inputs`, and the value of every metric by its
name; a metric without a value may be missing."""

FIXED_COLUMNS = (
    *("index", "key", "seed", "tracker"),
    *("status", "error", "trace_hash", "frames", "wall_s", "why", "inputs"),
)
TYPES = {"index": pa.int64(), "seed": pa.int64(), "frames": pa.int64(), "wall_s": pa.float64()}
"""Types of the fixed columns that hold numbers."""


@dataclass(frozen=True, slots=True)
class RowFormat:
    """Columns of a study; sent to workers, which write their rows as text."""

    parameters: tuple[str, ...]
    """Keys of the parameters, each a column."""
    texts: frozenset[str]
    """Parameters with a text or boolean among their values; their columns hold text."""
    own: tuple[str, ...] = ()
    """Names of the metrics of the study file."""

    @classmethod
    def of(cls, parameters: Mapping[str, Sequence[Any]], own: Collection[str] = ()) -> Self:
        """Return the format of a study with these values of each parameter, and metrics of its own."""
        texts = {key for key, values in parameters.items() if any(isinstance(value, bool | str) for value in values)}
        return cls(tuple(parameters), frozenset(texts), tuple(own))

    @property
    def schema(self) -> pa.Schema:
        """Columns with their types."""
        return _schema(self)

    def line(self, row: RunRow) -> str:
        """Return a row as a line of the append log, without columns that are not in the schema, or have no value."""
        kept = {name: _plain(row[name], kind) for name, kind in _types(self).items() if row.get(name) is not None}
        return json.dumps(kept, allow_nan=False) + "\n"


@cache
def _schema(form: RowFormat) -> pa.Schema:
    names = (*FIXED_COLUMNS[:4], *form.parameters, *FIXED_COLUMNS[4:], *METRICS, *form.own)
    return pa.schema([(name, _type(name, name in form.texts, name in form.parameters)) for name in names])


@cache
def _types(form: RowFormat) -> dict[str, pa.DataType]:
    schema = form.schema
    return dict(zip(schema.names, schema.types, strict=True))


def _type(name: str, is_text: bool, is_parameter: bool) -> pa.DataType:
    if name in METRICS or (name.startswith(PREFIX) and not is_parameter):
        return pa.float64()
    if is_parameter:
        return pa.string() if is_text else pa.float64()
    return TYPES.get(name, pa.string())


def _plain(value: Any, kind: pa.DataType) -> Any:
    """Return a value as JSON holds it; booleans and numbers of a text column become text."""
    return str(value) if kind == pa.string() else value
