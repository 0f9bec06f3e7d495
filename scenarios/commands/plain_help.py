"""Help of the program, its commands in groups, a line each; and of commands that read files."""

from typing import Any

import typer.core

from luxloop.plugins import ABILITIES, formats_that


class PlainHelp(typer.core.TyperGroup):
    """Group of commands whose help has a section for each `rich_help_panel`."""

    def format_help_text(self, ctx: Any, formatter: Any) -> None:
        """Write the description, then the sections in the order of their first commands."""
        super().format_help_text(ctx, formatter)
        groups: dict[Any, list[typer.core.TyperCommand]] = {}
        for name in self.list_commands(ctx):
            command = self.commands[name]
            assert isinstance(command, typer.core.TyperCommand)
            groups.setdefault(command.rich_help_panel, []).append(command)
        widest = max(map(len, self.commands))
        for group, commands in groups.items():
            with formatter.section(group):
                formatter.write_dl([(f"{each.name:{widest}}", each.short_help or "") for each in commands])

    def format_commands(self, ctx: Any, formatter: Any) -> None:
        """Write nothing after the options: the commands are above them."""


class FormatHelp(typer.core.TyperCommand):
    """Command whose help names the file formats that are found, in place of `{read_boxes}` and the like."""

    def format_help(self, *arguments: Any) -> None:
        """Write the help."""
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
