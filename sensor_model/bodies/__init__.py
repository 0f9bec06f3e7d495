"""Bodies and obstacles that beams meet."""
