"""Hook of mkdocs: show links to files outside docs/ as plain text, because the site does not contain these files."""

import re

OUTSIDE = re.compile(r"\[([^\]]+)\]\(\.\./[^)]*\)")


def on_page_markdown(markdown: str, **_: object) -> str:
    """Return the text of a page with the targets of such links removed."""
    return OUTSIDE.sub(r"\1", markdown)
