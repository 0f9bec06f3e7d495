"""Heading errors of the fits in the scenario `ring` with each kind of noise alone, and with several together."""

import luxloop
from luxloop.scenarios.metrics.definition import filtered
from luxloop.scenarios.report.paper_comparison import HEADING_ABS_DEG
from luxloop.sensor_model.noise.noise_config import KINDS, NoiseConfig

CRITERIA = {"area": "area", "closeness": "closeness", "variance": "variance", "tlinkage": "T-linkage", "best": "best"}
"""Criteria of the paper and the selection, by their method in the metrics."""
DEFAULT = tuple(kind for kind in KINDS if getattr(NoiseConfig(), kind).enabled)
PAPER = ("dropout", "mirror", "layer_overlap")
TOGETHER = {
    "the paper's three: " + ", ".join(PAPER): PAPER,
    "default: " + ", ".join(DEFAULT): DEFAULT,
    "all": KINDS,
}


def table(_name: str) -> str:
    """Return the mean absolute heading error [deg] by criterion, a row per kind of noise; four minutes."""
    rows = {"none": (), **{f"`{kind}`": (kind,) for kind in KINDS}, **TOGETHER}
    lines = [f"| noise | {' | '.join(CRITERIA.values())} |", f"| --- |{' ---: |' * len(CRITERIA)}"]
    lines += [f"| {name} | {' | '.join(errors(kinds))} |" for name, kinds in rows.items()]
    paper = (f"{HEADING_ABS_DEG[name][0]:.3f}" for name in CRITERIA)
    return "\n".join([*lines, f"| the paper's recordings | {' | '.join(paper)} |"])


def errors(kinds: tuple[str, ...]) -> list[str]:
    """Return the errors by criterion with these kinds of noise at their default strengths."""
    settings: dict[str, object] = {f"noise.{kind}.enabled": kind in kinds for kind in KINDS}
    settings["noise.attitude.full_from_mps"] = 0.0  # the ego stands; it sways as when it drives
    metrics = luxloop.run("ring", settings=settings).metrics
    return [f"{metrics[filtered('fit.heading_abs_mean_deg', method=name)].value:.3f}" for name in CRITERIA]
