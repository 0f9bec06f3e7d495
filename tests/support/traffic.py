"""Traffic sources, played for tests."""


def play(source, count):
    """Step a source that was reset, for what happens on the way."""
    for _ in range(count):
        source.step()


def frames(source, count, seed=1):
    """The first frames of a new run."""
    source.reset(seed)
    return [source.step() for _ in range(count)]
