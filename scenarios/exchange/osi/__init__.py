"""ASAM OSI 3 traces in MCAP: export of runs, and true boxes and tracks read back."""
