"""Detection: points to boxes."""
