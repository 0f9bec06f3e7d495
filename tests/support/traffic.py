"""Frames of traffic sources, and the names of highway-env's environments."""

import re

from support.paths import DOCS


def play(source, count):
    """Step a source after its reset, and discard the frames."""
    for _ in range(count):
        source.step()


def frames(source, count, seed=1):
    """Return the first frames of a new run."""
    source.reset(seed)
    return [source.step() for _ in range(count)]


def documented_environments():
    """Return the sorted ids of highway-env's environments in docs/traffic.md, without importing highway-env."""
    page = (DOCS / "traffic.md").read_text(encoding="utf-8")
    (table,) = re.findall(r"^\| environments \|.*\n((?:\|.*\n)+)", page, flags=re.MULTILINE)
    return sorted(re.findall(r"`([\w-]+-v\d)`", table))


def registered_environments():
    """Return the sorted ids of the environments that the installed highway-env registers."""
    import gymnasium
    import highway_env  # noqa: F401  registers its environments

    return sorted(name for name, spec in gymnasium.registry.items() if str(spec.entry_point).startswith("highway_env."))
