"""Frames of traffic sources for tests."""


def play(source, count):
    """Step a source after its reset, and discard the frames."""
    for _ in range(count):
        source.step()


def frames(source, count, seed=1):
    """Return the first frames of a new run."""
    source.reset(seed)
    return [source.step() for _ in range(count)]
