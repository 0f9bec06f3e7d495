"""`luxloop check-tracker`: whether a tracker keeps the contract of `scenarios.device`, with real and odd scans."""
