"""Content that a run depends on besides its parameters: files, source code and versions. Rows are reused by content."""

import hashlib
import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from luxloop.scenarios.run.versions import installed
from luxloop.scenarios.study import source_code
from luxloop.scenarios.study.named_files import Digests, named_files

Json = dict[str, Any]


@dataclass(frozen=True, slots=True)
class RunContent:
    """Digests of everything outside the scenario that determines the result of a run."""

    files: Digests
    """Files that the scenario names."""
    tracker: str
    """Source code of the tracker."""
    simulation: str
    """Source code of luxloop without the tracker."""
    versions: tuple[tuple[str, str], ...]
    """Installed packages."""


class Contents:
    """Content of the runs of one tracker; runs with the same files share one object.

    Source code is read once, when this object is made.

    Parameters
    ----------
    tracker
        MODULE:NAME, FILE.py:NAME or process:COMMAND of the device under test.
    """

    def __init__(self, tracker: str) -> None:
        self._tracker = source_code.of_tracker(tracker)
        self._simulation = source_code.of_simulation()
        self._versions = tuple(sorted(installed().items()))
        self._known: dict[Digests, RunContent] = {}

    def of(self, document: Json, folder: Path) -> RunContent:
        """Return the content of a scenario's run; relative paths in the scenario start from a folder."""
        files = (*named_files(document, folder), *_functions(document))
        if files not in self._known:
            self._known[files] = RunContent(files, self._tracker, self._simulation, self._versions)
        return self._known[files]


def _functions(document: Json) -> Digests:
    """Return the digests of the source of the functions in `[[metric]]` tables, which `MODULE:FUNCTION` names."""
    functions = [metric["function"] for metric in document.get("metric", []) if metric.get("function")]
    return tuple((name, source_code.of_tracker(name)) for name in dict.fromkeys(functions))


def inputs(document: Json, content: RunContent) -> Json:
    """Return the digests of all inputs of a run, as stored in its row."""
    return {
        "scenario": digest(document),
        "files": dict(content.files),
        "tracker": content.tracker,
        "luxloop": content.simulation,
        "versions": dict(content.versions),
    }


def digest(value: Any) -> str:
    """Return the digest of a JSON value."""
    return hashlib.blake2b(json.dumps(value, sort_keys=True, default=str).encode(), digest_size=12).hexdigest()


def changes(before: Json, now: Json) -> list[str]:
    """Return a text for each difference between the inputs of two runs: changed files, source code and versions."""
    words = {"scenario": "the scenario", "tracker": "the tracker's source", "luxloop": "luxloop's source"}
    found = [f"{word} changed" for key, word in words.items() if before.get(key) != now[key]]
    for name in sorted({*before.get("files", {}), *now["files"]}):
        was, is_now = before.get("files", {}).get(name), now["files"].get(name)
        if was != is_now:
            found.append(f"{name} {'changed' if was and is_now else 'is new' if is_now else 'is gone'}")
    for name in sorted({*before.get("versions", {}), *now["versions"]}):
        was, is_now = before.get("versions", {}).get(name), now["versions"].get(name)
        if was != is_now:
            found.append(f"{name} {was or 'missing'} became {is_now or 'missing'}")
    return found
