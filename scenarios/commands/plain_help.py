"""Help of commands as it is written."""

from typing import Any

import typer.core


class PlainHelp(typer.core.TyperCommand):
    """Command whose help may contain brackets, as in `[tracker]`; rich would take them for styles."""

    def __init__(self, *args: Any, **options: Any) -> None:
        from rich.markup import escape

        super().__init__(*args, **options)
        self.help = escape(self.help or "")
        for parameter in self.params:
            if isinstance(parameter, typer.core.TyperOption | typer.core.TyperArgument) and parameter.help:
                parameter.help = escape(parameter.help)
