"""Range checks of settings."""


def require_within(settings: object, low: float, high: float, *names: str) -> None:
    """Raise a ValueError for the first of the named settings outside `low` to `high`.

    The ranges exclude values for which the rounding errors of a covariance end in NaN.
    """
    for name in names:
        value = getattr(settings, name)
        if not low <= value <= high:
            raise ValueError(f"{name} is {value}; give {low:g} to {high:g}")
