"""Traffic sources and the world record: the ground truth, frame by frame."""

if not __name__.startswith("luxloop."):
    raise ImportError("sim is luxloop.sim: change the import to that name", name=__name__)
