"""Traffic sources in a worker process."""
