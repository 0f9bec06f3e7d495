"""`luxloop check-tracker`: checks that a tracker meets the contract of `luxloop.scenarios.run.device`."""
