"""Modules of version 0.1: their packages were top-level ones and are in `luxloop` now."""

PACKAGES = ("scenarios", "sensor_model", "sim", "tracker")


def remedy(error: BaseException, wanted: str = "") -> str:
    """Return the new name of a module of version 0.1 that was not found, else an empty text.

    Parameters
    ----------
    error
        Error of an import; it may name only the first part of a module.
    wanted
        The module that was to be imported.
    """
    name = error.name if isinstance(error, ModuleNotFoundError) else None
    if name is None or name.partition(".")[0] not in PACKAGES:
        return ""
    return f"; luxloop's module is luxloop.{wanted if wanted.startswith(f'{name}.') else name} now"
