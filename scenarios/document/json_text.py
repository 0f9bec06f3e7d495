"""Documents as JSON."""

import json
import math
from typing import Any

from luxloop.scenarios.document.document import Document


def json_text(document: Document, **more: str) -> str:
    """Return `json_data` on one line, with further keys."""
    return json.dumps({**json_data(document), **more}, allow_nan=False)


def json_data(document: Document) -> dict[str, Any]:
    """Return verdict, answer and the figures for programs; numbers without a value are None."""
    judged = {"verdict": document.answer.verdict} if document.answer.verdict else {}
    found: dict[str, Any] = finite({**judged, "answer": document.answer.sentence, **document.data})
    return found


def finite(value: Any) -> Any:
    """Replace NaN and infinity by None, and scalars of numpy by Python's, at any depth."""
    if isinstance(value, dict):
        return {key: finite(entry) for key, entry in value.items()}
    if isinstance(value, list | tuple):
        return [finite(entry) for entry in value]
    if hasattr(value, "item"):
        value = value.item()
    return None if isinstance(value, float) and not math.isfinite(value) else value
