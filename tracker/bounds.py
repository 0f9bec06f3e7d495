"""Bounds of settings."""


def require_within(settings: object, low: float, high: float, *names: str) -> None:
    """Raise a ValueError for the first of the named settings that is not `low` to `high`.

    What is far beyond any road would be lost to rounding in a covariance, and end as a number that is none.
    """
    for name in names:
        value = getattr(settings, name)
        if not low <= value <= high:
            raise ValueError(f"{name} is {value}; give {low:g} to {high:g}")
