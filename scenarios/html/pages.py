"""Templates and style, which become one file."""

from pathlib import Path
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined

from scenarios.errors import OutputError
from scenarios.grading.metrics import REGISTRY
from scenarios.html.palette import TONES
from scenarios.html.run import interval, with_unit


def render(template: str, **values: Any) -> str:
    """Fill in a template; what stands in a run is text, never markup."""
    environment = Environment(
        loader=PackageLoader("scenarios.html"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.globals.update(tones=TONES, registry=REGISTRY, with_unit=with_unit, interval=interval)
    return environment.get_template(template).render(**values)


def write(out: Path, page: str) -> None:
    """Write a page.

    Raises
    ------
    OutputError
        The file cannot be written.
    """
    try:
        out.parent.mkdir(parents=True, exist_ok=True)
        out.write_text(page, encoding="utf-8")
    except OSError as error:
        raise OutputError(f"{out}: cannot write there ({error.strerror}); choose another file with --out") from error
