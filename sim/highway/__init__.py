"""Traffic by highway-env; only this package imports it, and not before it is needed."""
