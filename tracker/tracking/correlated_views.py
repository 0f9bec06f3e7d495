"""Evidence of several views of one object, whose errors are correlated."""


def correlated_sum(total: float, views: int, correlation: float) -> float:
    """Return the evidence of a `total` of log-odds over views of one object, whose errors are correlated.

    The evidence of n equal views with correlation r is that of n / (1 + (n - 1) r).
    """
    return total / (1.0 + correlation * max(views - 1, 0))
