"""Studies: a scenario run for many combinations of parameters and seeds."""
