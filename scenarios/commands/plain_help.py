"""Help of the program: its commands in groups, a line each."""

from typing import Any

import typer.core


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
