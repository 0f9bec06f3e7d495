"""Studies: one scenario many times over, with parameters and seeds varied."""
