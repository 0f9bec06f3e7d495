"""`luxloop list` and `luxloop schema`."""

from typing import Annotated

import typer


def list_scenarios(
    folder: Annotated[bool, typer.Option("--folder", help="Print the folder they are in, for pytest.")] = False,
) -> None:
    """List the scenarios that ship, with a sentence on each."""
    from rich.console import Console
    from rich.table import Table

    from scenarios.listing import CATALOG, entries

    if folder:
        print(CATALOG)
        return
    table = Table("family", "name", "what happens", box=None, padding=(0, 2, 0, 0), header_style="bold")
    for entry in entries():
        table.add_row(*entry)
    Console().print(table)


def schema() -> None:
    """Print the JSON schema of scenario files, for editors."""
    from scenarios.scenario import schema_text

    print(schema_text(), end="")
