"""`luxloop check-tracker`: whether a tracker keeps the contract of `scenarios.run.device`, with real and odd scans."""
