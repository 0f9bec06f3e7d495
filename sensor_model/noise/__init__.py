"""What comes between the world and the reported points. Each kind of noise has its own switch, strength and cause."""
