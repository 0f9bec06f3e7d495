"""Traffic sources in a process of their own."""
