"""From a study to its runs: which combinations of parameters, with which seeds."""

import hashlib
import importlib
import inspect
import json
import math
import sys
from collections.abc import Callable
from dataclasses import dataclass, replace
from itertools import product
from pathlib import Path
from typing import Any, Self

import numpy as np

from scenarios.errors import ScenarioError, StudyError
from scenarios.files import shipped, toml_file
from scenarios.files.scenario import Scenario
from scenarios.files.shipped import CATALOG
from scenarios.run.versions import installed
from scenarios.study.keys import with_values
from scenarios.study.parameter import Value, Vary
from scenarios.study.study_file import Json, Study

SAMPLING_SEED = 0
"""Of the Latin hypercube: the same study has the same combinations, today and tomorrow."""


MOST_RUNS = 1_000_000
"""Of one study. A thousand cores take some hours over that many short ones."""


@dataclass(frozen=True, slots=True)
class StudyRun:
    """One run of a study: all that a worker needs."""

    index: int
    """Its place in the study."""
    parameters: dict[str, Value]
    seed: int
    document: Json
    """The whole scenario, as in a file."""
    path: Path
    """Where that file would be: its folder is where paths in the scenario start."""
    tracker: str
    """MODULE:NAME."""

    @property
    def key(self) -> str:
        """Tells the run from every other one: the same key means the same scenario, seed, tracker and versions."""
        what = [self.document, self.tracker, str(_from_catalog(self.path)), installed()]
        text = json.dumps(what, sort_keys=True, default=str)
        return hashlib.blake2b(text.encode(), digest_size=12).hexdigest()

    def portable(self) -> Self:
        """Return the run for a worker elsewhere: where that has the catalog, `CATALOG / path` is the file."""
        return replace(self, path=_from_catalog(self.path))


def _from_catalog(path: Path) -> Path:
    """Return the path of a shipped scenario from the catalog on; other paths as they are."""
    return path.relative_to(CATALOG) if path.is_relative_to(CATALOG) else path


def runs(study: Study, tracker: str) -> list[StudyRun]:
    """Return every run of a study: all seeds of the first combination, then of the next.

    Raises
    ------
    StudyError
        A key leads nowhere, the scene is not there, or a combination makes no valid scenario.
    """
    _check_size(study)
    make, path = source(study)
    found: list[StudyRun] = []
    for parameters in combinations(study):
        try:
            document = make({**study.fixed, **parameters})
            Scenario.of({**document, "seed": study.seed_list[0]}, path)
        except ScenarioError as error:
            told = ", ".join(f"{key} = {value}" for key, value in parameters.items())
            raise StudyError(f"{study.path}: with {told}: {error}") from error
        found += [
            StudyRun(len(found) + i, parameters, seed, {**document, "seed": seed}, path, tracker)
            for i, seed in enumerate(study.seed_list)
        ]
    return found


def combinations(study: Study) -> list[dict[str, Value]]:
    """Return every combination of the parameters: a grid, or as many as `samples` says from a Latin hypercube.

    Where all parameters have values only, the hypercube may name a combination twice; it runs once.
    """
    keys = [vary.key for vary in study.vary]
    if study.samples is None:
        return [dict(zip(keys, values, strict=True)) for values in product(*map(_grid, study.vary))]
    from scipy.stats import qmc

    unit = qmc.LatinHypercube(len(keys), rng=np.random.default_rng(SAMPLING_SEED)).random(study.samples)
    columns = [_drawn(vary, column) for vary, column in zip(study.vary, unit.T, strict=True)]
    return [dict(zip(keys, values, strict=True)) for values in dict.fromkeys(zip(*columns, strict=True))]


def _check_size(study: Study) -> None:
    """Refuse what nobody can mean, before it fills the memory."""
    grid = math.prod(len(vary.values) if vary.values is not None else vary.steps or 1 for vary in study.vary)
    count = (study.samples or grid) * (study.seeds if isinstance(study.seeds, int) else len(study.seeds))
    if count > MOST_RUNS:
        raise StudyError(
            f"{study.path}: {count} runs, more than {MOST_RUNS}; give fewer values, steps, samples or seeds"
        )


def _grid(vary: Vary) -> list[Value]:
    if vary.values is not None:
        return vary.values
    assert vary.low is not None
    assert vary.high is not None
    if vary.steps is None:  # only a study that is searched may leave them out
        raise StudyError(f"{vary.key}: a range without steps; give steps, or samples for the whole study, to sweep it")
    space = np.geomspace if vary.scale == "log" else np.linspace
    return [float(f"{value:.12g}") for value in space(vary.low, vary.high, vary.steps)]


def _drawn(vary: Vary, share: np.ndarray) -> list[Value]:
    """Values at these shares (N,) of the way, 0 to 1, through the values or the range."""
    if vary.values is not None:
        return [vary.values[int(s * len(vary.values))] for s in share]
    assert vary.low is not None
    assert vary.high is not None
    if vary.scale == "log":
        return [float(value) for value in vary.low * (vary.high / vary.low) ** share]
    return [float(value) for value in vary.low + (vary.high - vary.low) * share]


def source(study: Study) -> tuple[Callable[[dict[str, Any]], Json], Path]:
    """Return what makes a scenario's document of parameters, and the path it is to have."""
    if ":" in study.scenario:
        scene = _scene(study)
        name = study.scenario.partition(":")[2]
        return (lambda values: _staged(study, scene, values)), study.path.with_name(f"{name}.toml").absolute()
    path = (study.path.parent / shipped.find(study.scenario)).absolute()  # paths start at the file
    document = toml_file.read(path)
    return (lambda values: with_values(document, values)), path


def _scene(study: Study) -> Callable[..., Json]:
    module, _, name = study.scenario.partition(":")
    if (here := str(Path.cwd())) not in sys.path:
        sys.path.insert(0, here)  # modules of the current folder count, as for --tracker
    try:
        scene: Callable[..., Json] = getattr(importlib.import_module(module), name)
    except (ModuleNotFoundError, AttributeError) as error:
        raise StudyError(
            f"{study.path}: scenario = {study.scenario}: {error}; name a module and a function in it"
        ) from error
    return scene


def _staged(study: Study, scene: Callable[..., Json], parameters: dict[str, Any]) -> Json:
    """Stage a scene with its own parameters, then set what else is varied: keys of a scenario file have a dot."""
    own = {key: value for key, value in parameters.items() if "." not in key}
    try:
        inspect.signature(scene).bind(**own)
    except TypeError as error:
        raise StudyError(f"{study.path}: {study.scenario}: {error}; it takes {inspect.signature(scene)}") from error
    try:
        document = scene(**own)
    except ValueError as error:
        raise StudyError(f"{study.path}: {study.scenario}: {error}") from error
    return with_values(document, {key: value for key, value in parameters.items() if "." in key})
