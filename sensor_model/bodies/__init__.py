"""Bodies of road users, and static obstacles."""
