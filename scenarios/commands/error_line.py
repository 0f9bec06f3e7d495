"""What goes wrong, in one line."""

import sys

LONGEST_LINE = 1000
"""Letters. All environments of highway-env take 600; of what is longer, beginning and end tell the most."""


def complain(message: str, code: int) -> int:
    """Say it in one line that can be read, whatever a simulator or a file put into it, and return the exit code."""
    line = "".join(letter if letter.isprintable() else "?" for letter in " ".join(message.split()))
    if len(line) > LONGEST_LINE:
        line = f"{line[: LONGEST_LINE // 2]} ... {line[-LONGEST_LINE // 2 :]}"
    print(f"luxloop: error: {line}", file=sys.stderr)
    return code
