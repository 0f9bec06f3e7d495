"""League: several trackers on the same recorded scans, compared on one page."""
