"""The adversary: looks for the smallest disturbance that breaks the tracker, and shrinks it to a scenario file."""
