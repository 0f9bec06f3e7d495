"""The closed loop: a controller drives the ego by what the tracker sees, and again by the truth."""
