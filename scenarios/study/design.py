"""Experiment design: the runs of a study, from its parameters and seeds."""

import copy
import importlib
import inspect
import math
import re
import sys
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace
from functools import cache, cached_property
from itertools import product
from pathlib import Path
from typing import Any, Self

import numpy as np

from luxloop import former_names
from luxloop.scenarios.errors import ScenarioError, StudyError
from luxloop.scenarios.files import input_file, shipped
from luxloop.scenarios.files.scenario import Scenario
from luxloop.scenarios.files.shipped import CATALOG
from luxloop.scenarios.study import run_content
from luxloop.scenarios.study.parameter import Parameter, Value
from luxloop.scenarios.study.run_content import Contents, RunContent
from luxloop.scenarios.study.study_file import Json, Study

_STEP = re.compile(r'"([^"]+)"|\[([^\]]+)\]|([^.\[\]"]+)')


def parse(key: str) -> tuple[str, ...]:
    """Split a key into its steps; a step in brackets is the index or the name of a list item.

    Raises
    ------
    StudyError
        The key is malformed.
    """
    steps = tuple(f"[{match[2]}]" if match[2] else match[1] or match[3] for match in _STEP.finditer(key))
    if not steps or ".".join(steps).replace(".[", "[") != key.replace('"', ""):
        raise StudyError(
            f"{key}: not a valid key of a scenario file; use the form noise.dropout.random_rate or traffic.actor[0].x_m"
        )
    return steps


def with_values(document: Json, values: dict[str, Any]) -> Json:
    """Return a copy of a scenario document with these keys set; missing tables are created.

    Raises
    ------
    StudyError
        A key names a missing list item, or descends into a plain value.
    """
    changed = copy.deepcopy(document)
    for key, value in values.items():
        *parents, last = parse(key)
        node: Any = changed
        for step in parents:
            node = _child(node, step, key)
        if last.startswith("["):
            node[_index(node, last, key)] = value
        elif isinstance(node, dict):
            node[last] = value
        else:
            raise _not_in_a_table(key, last)
    return changed


def _child(node: Any, step: str, key: str) -> Any:
    if step.startswith("["):
        return node[_index(node, step, key)]
    if not isinstance(node, dict):
        raise _not_in_a_table(key, step)
    return node.setdefault(step, {})


def _index(node: Any, step: str, key: str) -> int:
    """Return the index of a list item given by its index or its `name`."""
    wanted = step[1:-1]
    if isinstance(node, list):
        if wanted.isdecimal() and int(wanted) < len(node):
            return int(wanted)
        names = [item.get("name") if isinstance(item, dict) else None for item in node]
        if names.count(wanted) == 1:
            return names.index(wanted)
    found = f"a list of {len(node)}" if isinstance(node, list) else "not a list"
    raise StudyError(f"{key}: no item {step}: found {found}; give an index from 0 on, or the name of one item")


def _not_in_a_table(key: str, step: str) -> StudyError:
    return StudyError(f"{key}: {step} is not inside a table; select a list item before it, e.g. actor[0]")


MakeDocument = Callable[[dict[str, Any]], Json]
"""Makes a scenario document from parameters."""

SAMPLING_SEED = 0
"""Seed of the Latin hypercube; fixed, so that a study always has the same combinations."""


MOST_RUNS = 1_000_000
"""Maximum number of runs of a study; short runs on a thousand cores take some hours for that many."""


@dataclass(frozen=True)
class StudyRun:
    """A run of a study, as sent to a worker."""

    index: int
    """Position in the study."""
    parameters: dict[str, Value]
    """Values of the varied parameters, by key."""
    seed: int
    document: Json
    """The complete scenario, as in a scenario file."""
    path: Path
    """Path that the scenario file would have: paths in the scenario are relative to its folder."""
    tracker: str
    """MODULE:NAME of the device under test."""
    content: RunContent
    """Files, source code and versions that the run depends on."""
    why: str = ""
    """Reason why the run is executed, for its row."""
    metrics: tuple[str, ...] = ()
    """Metrics of its row beside those that every result holds."""

    @cached_property
    def inputs(self) -> Json:
        """Digests of all inputs of the run."""
        return run_content.inputs(self.document, self.content)

    @cached_property
    def key(self) -> str:
        """Digest that identifies the run by content: scenario, seed, named files, tracker, source code and versions."""
        return run_content.digest([self.tracker, self.inputs, *self.metrics])

    def portable(self) -> Self:
        """Return the run for a worker on another computer, where `CATALOG / path` is the file of a shipped scenario."""
        return replace(self, path=_relative_to_catalog(self.path))

    def because(self, why: str) -> Self:
        """Return the run with the reason why it is executed; its key, if known, is not computed again."""
        run = replace(self, why=why)
        vars(run).update({name: value for name, value in vars(self).items() if name in ("key", "inputs")})
        return run


@cache
def _relative_to_catalog(path: Path) -> Path:
    """Return the path of a shipped scenario relative to the catalog, and any other path unchanged."""
    return path.relative_to(CATALOG) if path.is_relative_to(CATALOG) else path


def runs(study: Study, tracker: str) -> list[StudyRun]:
    """Return every run of a study: all seeds of the first combination, then of the next.

    Raises
    ------
    StudyError
        As for `plan`.
    """
    return [run for planned in plan(study, tracker) for run in planned]


def plan(study: Study, tracker: str, order: Iterable[int] | None = None) -> Iterator[list[StudyRun]]:
    """Yield the runs of each combination, with all seeds; a scene is built when its runs are due.

    Parameters
    ----------
    study
        The study.
    tracker
        MODULE:NAME of the device under test.
    order
        Numbers of the combinations, in the order in which they are built; default: that of the study.

    Raises
    ------
    StudyError
        A key does not exist, the scene cannot be imported, or a combination is not a valid scenario.
    """
    make, path = source(study)
    contents, found = Contents(tracker), combinations(study)
    for number in range(len(found)) if order is None else order:
        parameters = found[number]
        try:
            document = make({**study.fixed, **parameters})
            Scenario.of({**document, "seed": study.seed_list[0]}, path)
        except ScenarioError as error:
            values = ", ".join(f"{key} = {value}" for key, value in parameters.items())
            raise StudyError(f"{study.path}: with {values}: {error}") from error
        content = contents.of(document, path.parent)
        first = number * len(study.seed_list)
        yield [
            StudyRun(
                first + i,
                parameters,
                seed,
                {**document, "seed": seed},
                path,
                tracker,
                content,
                metrics=study.filtered_metrics,
            )
            for i, seed in enumerate(study.seed_list)
        ]


def combinations(study: Study) -> list[dict[str, Value]]:
    """Return all combinations of the parameters: the full grid, or `samples` points of a Latin hypercube.

    If all parameters have listed values, a hypercube can contain a combination twice; it is returned once.

    Raises
    ------
    StudyError
        The study has more than `MOST_RUNS` runs, or a range has no steps.
    """
    _check_size(study)
    keys = [parameter.key for parameter in study.vary]
    if study.samples is None:
        return [dict(zip(keys, values, strict=True)) for values in product(*map(_grid, study.vary))]
    from scipy.stats import qmc

    unit = qmc.LatinHypercube(len(keys), rng=np.random.default_rng(SAMPLING_SEED)).random(study.samples)
    columns = [_samples(parameter, column) for parameter, column in zip(study.vary, unit.T, strict=True)]
    return [dict(zip(keys, values, strict=True)) for values in dict.fromkeys(zip(*columns, strict=True))]


def _check_size(study: Study) -> None:
    """Raise a StudyError if the study has too many runs to be held in memory."""
    grid = math.prod(
        len(parameter.values) if parameter.values is not None else parameter.steps or 1 for parameter in study.vary
    )
    count = (study.samples or grid) * (study.seeds if isinstance(study.seeds, int) else len(study.seeds))
    if count > MOST_RUNS:
        raise StudyError(
            f"{study.path}: {count} runs, more than {MOST_RUNS}; give fewer values, steps, samples or seeds"
        )


def _grid(parameter: Parameter) -> list[Value]:
    if parameter.values is not None:
        return parameter.values
    assert parameter.low is not None
    assert parameter.high is not None
    if parameter.steps is None:  # optional in a study with [search] only
        raise StudyError(f"{parameter.key}: a range without steps; give steps, or samples for the whole study")
    space = np.geomspace if parameter.scale == "log" else np.linspace
    return [float(f"{value:.12g}") for value in space(parameter.low, parameter.high, parameter.steps)]


def _samples(parameter: Parameter, fraction: np.ndarray) -> list[Value]:
    """Return the values at fractions (N,), 0 to 1, of the listed values or the range."""
    if parameter.values is not None:
        return [parameter.values[int(f * len(parameter.values))] for f in fraction]
    assert parameter.low is not None
    assert parameter.high is not None
    if parameter.scale == "log":
        return [float(value) for value in parameter.low * (parameter.high / parameter.low) ** fraction]
    return [float(value) for value in parameter.low + (parameter.high - parameter.low) * fraction]


def source(study: Study) -> tuple[MakeDocument, Path]:
    """Return a function that makes a scenario document from parameters, and the path of the document.

    Raises
    ------
    StudyError, ScenarioError
        The scene cannot be imported; the scenario file is missing or not TOML.
    """
    if ":" in study.scenario:
        scene = _scene(study)
        name = study.scenario.partition(":")[2]
        place = study.path.with_name(f"{name}.toml").absolute()
        return (lambda values: _with_metrics(study, _staged(study, scene, study.scenario_values(values)))), place
    path = (study.path.parent / shipped.find(study.scenario)).absolute()  # relative paths start at the study file
    document = input_file.read_toml(path)
    return (lambda values: _with_metrics(study, with_values(document, study.scenario_values(values)))), path


def _with_metrics(study: Study, document: Json) -> Json:
    """Add the metrics of the study to those of the scenario; without any the document is unchanged."""
    own = [metric.model_dump(mode="json", by_alias=True, exclude_defaults=True) for metric in study.metric]
    return {**document, "metric": [*document.get("metric", []), *own]} if own else document


def _scene(study: Study) -> Callable[..., Json]:
    module, _, name = study.scenario.partition(":")
    if (here := str(Path.cwd())) not in sys.path:
        sys.path.insert(0, here)  # modules of the current folder can be imported, as with --tracker
    try:
        scene: Callable[..., Json] = getattr(importlib.import_module(module), name)
    except (ImportError, AttributeError) as error:
        reason = f"{error}{former_names.remedy(error, module)}"
        raise StudyError(
            f"{study.path}: scenario = {study.scenario}: {reason}; name a module and a function in it"
        ) from error
    return scene


def _staged(study: Study, scene: Callable[..., Json], parameters: dict[str, Any]) -> Json:
    """Call a scene function with its arguments, then set the keys of the scenario file (those with a dot)."""
    arguments = {key: value for key, value in parameters.items() if "." not in key}
    try:
        inspect.signature(scene).bind(**arguments)
    except TypeError as error:
        raise StudyError(f"{study.path}: {study.scenario}: {error}; it takes {inspect.signature(scene)}") from error
    try:
        document = scene(**arguments)
    except ValueError as error:
        raise StudyError(f"{study.path}: {study.scenario}: {error}") from error
    return with_values(document, {key: value for key, value in parameters.items() if "." in key})
