"""Message formats of real units."""
