"""Console of rich that shows text in documents, tables and bars as `luxloop.printable` does."""

from collections.abc import Iterable

from rich.console import Console, ConsoleOptions, RenderableType
from rich.segment import Segment

from luxloop.printable import printable


class PrintableConsole(Console):
    """Console whose only escape sequences are its own: those of colours and of bars.

    Texts are measured before, so that a table may cut off the end of an escaped name.
    """

    def render(self, renderable: RenderableType, options: ConsoleOptions | None = None) -> Iterable[Segment]:
        """Yield the segments of a renderable, with printable text."""
        for segment in super().render(renderable, options):
            is_own = segment.control or segment.text.isprintable()
            yield segment if is_own else Segment(printable(segment.text), segment.style)
