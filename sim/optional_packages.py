"""Command that installs the packages of an extra of luxloop.

It names the packages themselves: it works for a checkout and for a wheel, and no index needs to have luxloop.
"""

import re
import shlex
from importlib.metadata import PackageNotFoundError, requires

_OF_EXTRA = re.compile(r"""(?P<requirement>[^;]*?)\s*;\s*extra\s*==\s*['"](?P<extra>[^'"]+)['"]\s*""")


def install_command(extra: str) -> str:
    """Return the command for an extra, with the versions that the installed metadata demands."""
    try:
        found = [match for line in requires("luxloop") or () if (match := _OF_EXTRA.fullmatch(line))]
    except PackageNotFoundError:  # a checkout on the Python path, which is not installed
        return f"pip install -e '.[{extra}]' in the checkout"
    packages = [match["requirement"] for match in found if match["extra"] == extra]
    return f"pip install {shlex.join(packages)}"
