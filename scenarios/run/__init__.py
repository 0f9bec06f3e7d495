"""The run loop and what it needs."""
