"""`luxloop check-tracker`: checks that a tracker meets the contract of `scenarios.run.device`."""
