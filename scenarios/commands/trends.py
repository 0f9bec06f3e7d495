"""`luxloop trends`."""

from pathlib import Path
from typing import Annotated

import typer


def trends(
    baselines: Annotated[
        list[Path],
        typer.Argument(metavar="BASELINE...", help="Files of `luxloop baseline`, or folders of runs; earliest first."),
    ],
    out: Annotated[Path, typer.Option(metavar="FILE", help="The page to write.")] = Path("trends.html"),
) -> None:
    """Draw the key metrics over many baselines, of all runs together and of each scenario, on one page."""
    from luxloop.scenarios.compare import sides, trends_page
    from luxloop.scenarios.compare.trend_values import trends as trends_of
    from luxloop.scenarios.report import text
    from luxloop.scenarios.report.html import pages

    found = trends_of([sides.read(path) for path in baselines])
    pages.write(out, trends_page.trends_page(found))
    text.show(trends_page.suite_table(found))
    print(f"The page is {out}")
