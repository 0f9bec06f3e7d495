"""`luxloop list` and `luxloop schema`."""

from typing import Annotated

import typer


def list_scenarios(
    folder: Annotated[bool, typer.Option("--folder", help="Print the folder they are in, for pytest.")] = False,
    studies: Annotated[bool, typer.Option("--studies", help="List the studies instead.")] = False,
) -> None:
    """List the scenarios that ship, with a sentence on each."""
    from rich.console import Console
    from rich.table import Table

    from scenarios import listing

    if folder:
        print(listing.STUDIES if studies else listing.CATALOG)
        return
    columns = ("command", "name", "what it asks") if studies else ("family", "name", "what happens")
    table = Table(*columns, box=None, padding=(0, 2, 0, 0), header_style="bold")
    for entry in listing.study_entries() if studies else listing.entries():
        table.add_row(*entry)
    Console().print(table)


def schema(
    study: Annotated[bool, typer.Option("--study", help="Of study files instead.")] = False,
) -> None:
    """Print the JSON schema of scenario files, for editors."""
    from scenarios.scenario import Scenario, schema_text
    from scenarios.study.study import Study

    print(schema_text(Study if study else Scenario), end="")
