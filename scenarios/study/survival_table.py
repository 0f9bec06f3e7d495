"""Numbers of a survival curve: runs, events, medians with intervals, and log-rank tests against the first curve."""

import math

import pandas as pd

from luxloop.scenarios.grading.emergence_names import SURVIVAL, survival_measure
from luxloop.scenarios.study import survival
from luxloop.scenarios.study.figures import label, text
from luxloop.scenarios.study.study_file import Curve, Study
from luxloop.scenarios.study.survival_picture import curve_of, groups


def survival_lines(study: Study, rows: pd.DataFrame, curve: Curve) -> tuple[list[str], list[list[str]]]:
    """Return the head of the table, and a line per curve."""
    found = survival.samples(rows, curve.metric, curve.keys)
    measure = (survival_measure(curve.metric) or ("", ""))[1]
    head = [*(label(study, key) for key in curve.keys), "runs", "reached", "median", "95 %"]
    lines = []
    for panel, in_panel in groups(found, curve.panels):
        first: pd.DataFrame | None = None
        for level, shown in groups(in_panel, curve.by):
            names = [text(value) for key, value in ((curve.panels, panel), (curve.by, level)) if key is not None]
            line = [*names, str(len(shown)), str(int(shown["reached"].sum())), *_median(shown, SURVIVAL[measure])]
            if curve.by:
                line.append("" if first is None else _p_value(survival.log_rank(first, shown)))
            first = shown if first is None else first
            lines.append(line)
    return [*head, *(["log-rank p against the first"] if curve.by else [])], lines


def _median(shown: pd.DataFrame, falls: bool) -> list[str]:
    """Return the median and its interval as text, in the order of the measure."""
    middle, *ends = survival.median(curve_of(shown))
    interval = "one seed" if shown["seed"].nunique() < 2 else " to ".join(_value(end, falls) for end in ends)
    return [_value(middle, falls), interval]


def _value(time: float, falls: bool) -> str:
    return "never" if math.isinf(time) else f"{-time if falls else time:.3g}"


def _p_value(p: float) -> str:
    return "-" if math.isnan(p) else "< 0.001" if p < 0.001 else f"{p:.3f}"
