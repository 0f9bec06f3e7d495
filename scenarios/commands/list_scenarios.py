"""`luxloop list`."""

from typing import Annotated

import typer


def list_scenarios(
    folder: Annotated[bool, typer.Option("--folder", help="Print the folder of the files, for pytest.")] = False,
    studies: Annotated[bool, typer.Option("--studies", help="List the studies instead.")] = False,
) -> None:
    """List the shipped scenarios with a one-line description each."""
    from rich.console import Console
    from rich.table import Table

    from scenarios.files import shipped

    if folder:
        print(shipped.STUDIES if studies else shipped.CATALOG)
        return
    columns = ("command", "name", "question") if studies else ("family", "name", "description")
    table = Table(*columns, box=None, padding=(0, 2, 0, 0), header_style="bold")
    for entry in shipped.study_entries() if studies else shipped.entries():
        table.add_row(*entry)
    Console().print(table)
