"""Traffic sources and the world record: the ground truth, frame by frame."""
