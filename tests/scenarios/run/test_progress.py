"""Progress of the start: the share of a file that has been read."""

import pytest

from luxloop.scenarios.run.progress import _share_read
from luxloop.sim.source import StartStatus


def test_the_share_of_a_file_is_the_position_in_it(tmp_path):
    net = tmp_path / "city.net.xml"
    net.write_bytes(bytes(1_000_000))
    status = StartStatus("SUMO loads it", file=str(net))

    assert _share_read(status) is None  # not open yet
    with net.open("rb", buffering=0) as stream:
        stream.read(250_000)
        assert _share_read(status) == pytest.approx(0.25)
