"""Traffic by highway-env, which only this package imports, lazily."""
