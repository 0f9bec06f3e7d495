"""Traffic sources and the world record: what is really there, frame by frame."""
