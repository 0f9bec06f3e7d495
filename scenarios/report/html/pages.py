"""Rendering of templates, and writing of pages."""

import base64
import hashlib
import re
from functools import cache
from importlib import resources
from pathlib import Path
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup, escape

from luxloop.scenarios.errors import OutputError
from luxloop.scenarios.files import atomic_file
from luxloop.scenarios.metrics.definitions import find_metric, is_metric
from luxloop.scenarios.report.html.palette import TONES
from luxloop.scenarios.report.html.reported_run import interval, with_unit


def render(template: str, **values: Any) -> str:
    """Fill in a template; all values are escaped, so the contents of a run are never markup."""
    environment = Environment(
        loader=PackageLoader("luxloop.scenarios.report.html"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.globals.update(tones=TONES, find_metric=find_metric, is_metric=is_metric)
    environment.globals.update(with_unit=with_unit, interval=interval)
    environment.filters["breakable"] = breakable
    environment.globals.update(script=script, script_hash=script_hash)
    return environment.get_template(template).render(**values)


def breakable(name: str) -> Markup:
    """Return the name of a metric that a narrow column may break after its points and underscores."""
    return Markup(re.sub(r"(?<=[a-z])([._])(?=\w)", r"\1<wbr>", str(escape(name))))


@cache
def script() -> Markup:
    """Return the script of the frame player, the only one of any page."""
    return Markup(
        (resources.files("luxloop.scenarios.report.html") / "templates" / "player.js").read_text(encoding="utf-8")
    )


def script_hash() -> str:
    """Return the source expression of a content security policy that allows this script and no other one."""
    return "sha256-" + base64.b64encode(hashlib.sha256(script().encode()).digest()).decode()


def write(out: Path, page: str, option: str = "--out") -> None:
    """Write a page atomically; `option` is the one that chose `out`, for the message.

    Raises
    ------
    OutputError
        The file cannot be written.
    """
    try:
        out.parent.mkdir(parents=True, exist_ok=True)
        with atomic_file.create(out) as temporary:
            temporary.write_text(page, encoding="utf-8")
    except OSError as error:
        raise OutputError(f"{out}: cannot write there ({error.strerror}); choose another file with {option}") from error
