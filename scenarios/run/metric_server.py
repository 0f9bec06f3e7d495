"""Process of the functions of own metrics: it imports the user's code and calls it with tables of the run.

The only request is pickled and comes from the judge: names and functions, the folder of their modules, and the tables,
or None to import only. The answer is JSON: a number, None or an error by name.
"""

from pathlib import Path
from typing import Any

from luxloop.scenarios.run import one_request, user_code


def serve() -> None:
    """Answer the request."""
    one_request.answer(values)


def values(request: tuple[dict[str, str], str, dict[str, Any] | None]) -> dict[str, dict[str, Any]]:
    """Return the answer to a request."""
    functions, folder, tables = request
    return {name: _answer(function, Path(folder), tables) for name, function in functions.items()}


def _answer(function: str, folder: Path, tables: dict[str, Any] | None) -> dict[str, Any]:
    """Return the value of a function, or why there is none."""
    try:
        called = user_code.load(function, folder, "name a function")
    except user_code.UserCodeError as error:
        return {"not_loaded": str(error)}
    if tables is None:
        return {}
    try:
        value: Any = called({name: table.copy() for name, table in tables.items()})
    except BaseException as error:  # all that the user's code can raise
        return {"error": f"{user_code.place_of(error, (__file__,))}{type(error).__name__}: {user_code.text_of(error)}"}
    try:
        if not isinstance(value, str | bytes):  # of which float() reads numbers
            return {"value": None if value is None else float(value)}
    except BaseException:  # its class may do anything
        pass
    return {"type": type(value).__name__}
