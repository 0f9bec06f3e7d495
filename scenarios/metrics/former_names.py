"""Names of metrics until version 0.1, and their present ones."""

import re
from functools import lru_cache

TARGETS = {"stationary_target": "standing", "moving_target": "moving"}
VIEWS = "l_shape|side|rear|front|none"
MODELS = "stationary|cv|ca|ctrv|ctra|two-axle|mma"
STAGES = "first_beam|enough_points|tentative|confirmed|located|end"

FORMER: tuple[tuple[str, str, str], ...] = (
    (rf"fit\.(?:(?P<view>{VIEWS})\.)?(?P<method>\w+)\.(?P<figure>\w+)", "fit.{figure}", "method,view"),
    (rf"dataset\.(?P<view>{VIEWS})\.(?P<figure>\w+)", "dataset.{figure}", "view"),
    (r"outliers\.(?P<cause>\w+)\.(?P<figure>\w+)", "outliers.{figure}", "cause"),
    (rf"mma\.(?P<model>{MODELS})\.(?P<target>\w+_target)\.(?P<figure>\w+)", "mma.{figure}", "model,target"),
    (rf"mma\.(?P<model>{MODELS})\.(?P<figure>\w+?)(?P<when>_around_changes)?", "mma.{figure}", "model,when"),
    (r"mma\.(?P<figure>gain)\.(?P<target>\w+)", "mma.{figure}", "target"),
    (r"mma\.confusion\.(?P<mode>[\w-]+)\.(?P<model>[\w-]+)", "mma.selected", "mode,model"),
    (rf"emergence\.(?P<group>\w+)\.(?P<stage>{STAGES})_(?P<figure>\w+)", "emergence.{figure}", "stage,group"),
    (r"track\.(?P<figure>missed|false)_rate", "track.{figure}_share", ""),
    (r"(?P<figure>[\w.]+)", "{figure}", ""),
)
"""Pattern of the former name without its band, the present name, and its parameters in their order."""
DEFAULTS = {"method": "best", "model": "mma", "group": "target"}
"""Values that need not be named."""


@lru_cache(maxsize=4096)
def present_name(name: str) -> str:
    """Return the present name of a metric with a former name; empty if it is none."""
    base, *bands = re.split(r"\.by_(?=range|class|view|points)", name)
    filters = {}
    for band in bands:
        key, _, value = band.partition(".")
        filters[key] = value.replace("_up", "-").replace("_", "-") if key in ("range", "points") else value
    for pattern, present, keys in FORMER:
        if found := re.fullmatch(pattern, base):
            given = {key: _value(key, found[key]) for key in filter(None, keys.split(",")) if found[key]}
            figure = present.format(figure=_figure(base, found.groupdict().get("figure") or ""))
            chosen = {key: value for key, value in given.items() if value != DEFAULTS.get(key)} | filters
            inside = ",".join(f"{key}={value}" for key, value in chosen.items())
            later = f"{figure}{{{inside}}}" if inside else figure
            return later if later != name else ""
    return ""


def _value(key: str, value: str) -> str:
    return {"target": TARGETS.get(value, value), "when": "changing"}.get(key, value)


def _figure(base: str, figure: str) -> str:
    return "time_s" if base.startswith("emergence.") and figure == "s" else figure
