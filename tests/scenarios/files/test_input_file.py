"""Inputs that never end: devices, pipes, and small files that expand to gigabytes."""

import os

import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from support.optional import need

from luxloop.errors import Error
from luxloop.scenarios.compare import baseline_file
from luxloop.scenarios.errors import InputError
from luxloop.scenarios.exchange import file_formats
from luxloop.scenarios.files import input_file
from luxloop.scenarios.offline import track_file
from luxloop.scenarios.recordings.formats.format_choice import require_bytes
from luxloop.sensor_model.rig import toml_table

READERS = {
    "scenario": input_file.read_toml,
    "rig": toml_table.read_table,
    "baseline": baseline_file.read,
    "boxes": lambda path: file_formats.read(path, "truth"),
    "tracks": lambda path: track_file.read_table(path, parquet=False),
    "recording": lambda path: require_bytes([path]),
    "parquet": input_file.read_parquet,
}


@pytest.mark.parametrize("kind", READERS)
def test_a_pipe_is_refused_before_it_is_read(kind, tmp_path):
    """Opening it would wait for a writer for ever."""
    os.mkfifo(tmp_path / "pipe")
    with pytest.raises(Error, match="pipe: is a device or a pipe; give a file"):
        READERS[kind](tmp_path / "pipe")


def test_a_parquet_file_of_equal_rows_is_read_up_to_a_limit(tmp_path, monkeypatch):
    path = tmp_path / "a.parquet"
    pq.write_table(pa.table({"x": pa.repeat(1, 500_000), "y": pa.repeat(2, 500_000)}), path)
    assert input_file.read_parquet(path).num_rows == 500_000
    monkeypatch.setattr(input_file, "ALWAYS_BYTES", 2**20)
    assert path.stat().st_size < 40_000
    with pytest.raises(InputError, match=r"a\.parquet: its 500000 rows expand to more than 100 times its size"):
        input_file.read_parquet(path)


@pytest.mark.parametrize("understated", [False, True])
def test_a_chunk_of_mcap_that_expands_to_many_times_its_size_is_refused(tmp_path, understated):
    """Its index may state a smaller size than its frame of Zstandard."""
    need("mcap")
    from mcap.reader import make_reader
    from mcap.writer import CompressionType, Writer

    from luxloop.scenarios.offline.mcap.chunks import require_chunks, require_sizes

    path = tmp_path / "a.mcap"
    with path.open("wb") as stream:
        writer = Writer(stream, compression=CompressionType.ZSTD, chunk_size=2**26)
        writer.start()
        channel = writer.register_channel("/t", "cdr", writer.register_schema("a/msg/A", "ros2msg", b""))
        writer.add_message(channel, 0, bytes(20 * 2**20), 0)
        writer.finish()
    with path.open("rb") as stream:
        summary = make_reader(stream).get_summary()
    (index,) = summary.chunk_indexes
    index.uncompressed_size = 100 if understated else index.uncompressed_size
    with pytest.raises(InputError, match=r"a\.mcap: a chunk expands to .* bytes, more than 100 times its size"):
        require_sizes(path, [index])
    with pytest.raises(InputError, match="a chunk expands"):
        require_chunks(path)


def test_a_chunk_of_a_bag_that_expands_to_many_times_its_size_is_refused(tmp_path):
    need("recordings")
    from rosbags.rosbag1 import Writer
    from rosbags.typesys import Stores, get_typestore

    from luxloop.scenarios.recordings.formats import ros_bags
    from luxloop.scenarios.recordings.formats.format_choice import ReadOptions

    path, kind = tmp_path / "a.bag", "sensor_msgs/msg/PointCloud2"
    writer = Writer(path)
    writer.set_compression(Writer.CompressionFormat.BZ2)
    with writer:
        topic = writer.add_connection("/points", kind, typestore=get_typestore(Stores.ROS1_NOETIC))
        writer.write(topic, 0, bytes(20 * 2**20))
    assert path.stat().st_size < 20_000
    with pytest.raises(InputError, match=r"a\.bag: a chunk is cut off, or expands to more than 100 times its size"):
        list(ros_bags.open_recording([path], ReadOptions()).sweeps())


@pytest.mark.parametrize("mode", ["message", "file"])
def test_bags_of_ros_2_are_expanded_up_to_a_limit(tmp_path, mode, monkeypatch):
    need("recordings")
    from rosbags.rosbag2 import CompressionFormat, CompressionMode, Writer
    from rosbags.typesys import Stores, get_typestore

    from luxloop.scenarios.recordings.formats import ros_bags
    from luxloop.scenarios.recordings.formats.format_choice import ReadOptions

    writer = Writer(tmp_path / "bag", version=9)
    writer.set_compression(CompressionMode[mode.upper()], CompressionFormat.ZSTD)
    with writer:
        kind = "sensor_msgs/msg/PointCloud2"
        topic = writer.add_connection("/points", kind, typestore=get_typestore(Stores.ROS2_HUMBLE))
        writer.write(topic, 0, bytes(2**20))
    with pytest.raises(InputError, match="bag: not readable"):  # the message is no cloud
        list(ros_bags.open_recording([tmp_path / "bag"], ReadOptions()).sweeps())
    monkeypatch.setattr(ros_bags, "ALWAYS_BYTES", 2**19)
    with pytest.raises(InputError, match="bag: a chunk is cut off, or expands to more than 100 times its size"):
        list(ros_bags.open_recording([tmp_path / "bag"], ReadOptions()).sweeps())
