"""Names of metrics that tests compare as a whole: the standard ones, and those of methods, models, views and bands."""

from luxloop.scenarios.metrics.definition import filtered
from luxloop.scenarios.metrics.definitions import (
    CANDIDATES,
    DEFINITIONS,
    OF_LOOP,
    POINT_BANDS,
    REPORTED_BANDS,
    TARGETS,
    VIEWS,
    find_metric,
    standard_names,
)
from luxloop.tracker.records import MODELS, TURNING_MODELS

OF_METHODS = [name for name, definition in DEFINITIONS.items() if "method" in definition.parameters]
SINGLE_FITS = [
    filtered(name, method=method, view=view)
    for name in OF_METHODS
    for method in (*CANDIDATES, "oracle")
    for view in ("", *VIEWS.values())
]
"""Figures of fits of every method but the selection."""
SELECTED_FITS = [
    filtered(name, **band)
    for name, definition in DEFINITIONS.items()
    if definition.kind == "fit"
    for band in (*({"view": view} for view in VIEWS.values()), *({"points": band} for band in POINT_BANDS))
]
OF_MODELS = [
    filtered(name, model=model, target=target)
    for name, definition in DEFINITIONS.items()
    if "target" in definition.parameters and "model" in definition.parameters
    for model in ("", *MODELS)
    for target in TARGETS
] + [
    filtered(name, model=model)
    for name, definition in DEFINITIONS.items()
    if "model" in definition.parameters
    and "target" not in definition.parameters
    and "mode" not in definition.parameters
    for model in MODELS
]
BANDED = [
    filtered(name, **band)
    for name, definition in DEFINITIONS.items()
    if name.startswith("track.") and "range" in definition.filters and not definition.needs
    for band in REPORTED_BANDS
]
STANDARD = [
    name
    for name in standard_names()
    if not any(model in name for model in TURNING_MODELS) and not find_metric(name).definition.needs
]
METRICS = list(dict.fromkeys([*STANDARD, *SINGLE_FITS, *SELECTED_FITS, *OF_MODELS, *BANDED]))
"""About 2000 names, without those of models that the standard filter bank does not have, and of boxes of files."""
GRADED = [name for name in METRICS if find_metric(name).definition.kind not in OF_LOOP]
"""Those that grading computes."""
