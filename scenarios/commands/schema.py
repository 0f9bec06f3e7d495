"""`luxloop schema`."""

from typing import Annotated

import typer


def schema(
    study: Annotated[bool, typer.Option("--study", help="Print the schema of study files instead.")] = False,
) -> None:
    """Print the JSON schema of scenario files, for completion in editors."""
    from luxloop.scenarios.files.scenario import Scenario, schema_text
    from luxloop.scenarios.study.study_file import Study

    print(schema_text(Study if study else Scenario), end="")
