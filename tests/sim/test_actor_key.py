"""Keys of actors by name."""

import numpy as np

from luxloop.sim.actor_draws import Stream, actor_key, actor_rng


def test_keys_are_the_digest_of_the_name():
    """Expected value by `printf taxi | b2sum -l 64`, read as little-endian."""
    assert actor_key("taxi") == int.from_bytes(bytes.fromhex("c612d250a4511e1e"), "little")
    assert actor_key("") != actor_key("ä") != actor_key("a")


def test_draws_differ_by_seed_name_and_purpose():
    paint, size = Stream.PAINT, Stream.SIZE
    keys = [(1, "taxi", paint), (2, "taxi", paint), (1, "bus", paint), (1, "taxi", size)]
    draws = [float(actor_rng(*key).random()) for key in keys]
    assert len(set(draws)) == len(draws)
    assert draws[0] == float(actor_rng(1 + 2**64, "taxi", Stream.PAINT).random()), "the seed is taken modulo 2^64"


def test_draws_of_numbered_names_are_uniform():
    """Fails if similar names gave similar keys. Four standard deviations of the mean of uniform draws."""
    draws = np.array([actor_rng(7, f"flow.{number}", Stream.PAINT).random() for number in range(2000)])
    assert abs(draws.mean() - 0.5) < 4 * np.sqrt(1 / 12 / len(draws))
    assert abs(np.corrcoef(draws[:-1], draws[1:])[0, 1]) < 4 / np.sqrt(len(draws))
