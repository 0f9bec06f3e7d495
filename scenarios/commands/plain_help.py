"""Help of commands as it is written."""

from typing import Any

import typer.core

from luxloop.plugins import ABILITIES, formats_that


class PlainHelp(typer.core.TyperCommand):
    """Command whose help may contain brackets, as in `[tracker]`; rich would take them for styles."""

    def __init__(self, *args: Any, **options: Any) -> None:
        from rich.markup import escape

        super().__init__(*args, **options)
        self.help = escape(self.help or "")
        for parameter in self.params:
            if isinstance(parameter, typer.core.TyperOption | typer.core.TyperArgument) and parameter.help:
                parameter.help = escape(parameter.help)

    def format_help(self, *arguments: Any) -> None:
        """Write the help, with the file formats that are found in place of `{read_boxes}` and the like."""
        for parameter in self.params:
            if isinstance(parameter, typer.core.TyperOption) and parameter.help:
                parameter.help = _with_formats(parameter.help)
        super().format_help(*arguments)


def _with_formats(text: str) -> str:
    for ability in ABILITIES:
        place = f"{{{ability}}}"
        if place in text:
            text = text.replace(place, ", ".join(formats_that(ability)))
    return text
