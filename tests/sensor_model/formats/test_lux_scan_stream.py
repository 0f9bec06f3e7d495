"""Streams of LUX scan messages."""

import struct

import pytest
from support.real_data import real_file

from luxloop.sensor_model.formats.lux_scan_message import LuxHeader, decode, encode
from luxloop.sensor_model.formats.lux_scan_stream import read_stream, stream_bytes


def _message(number, points):
    header = LuxHeader(number, 0, 0, 1 << 32, (1 << 32) + 7, 11520, 1600, -1600, points, 0, 0, 0, 0, 0, 0, 0)
    words = struct.pack("<HHHQQHhhHhhhhhhH", *(getattr(header, name) for name in LuxHeader.__slots__))
    return decode(words + bytes(range(10)) * points)


MESSAGES = [_message(7, 2), _message(8, 0), _message(9, 3)]
PLAIN = b"".join(map(encode, MESSAGES))
FRAMED = b"".join(stream_bytes(MESSAGES, device=7))
OTHER = bytes.fromhex("affec0c2 00000000 00000003 00 07 2030 0000000000000000") + b"abc"


def _read(tmp_path, data, **options):
    path = tmp_path / "scans.bin"
    path.write_bytes(data)
    return [encode(message) for message in read_stream(path, **options)]


def test_plain_messages_follow_one_another(tmp_path):
    assert b"".join(stream_bytes(MESSAGES)) == PLAIN
    assert _read(tmp_path, PLAIN) == list(map(encode, MESSAGES))


def test_data_headers_are_big_endian_and_name_the_size_of_the_previous_message(tmp_path):
    assert FRAMED[:24] == bytes.fromhex("affec0c2 00000000 00000040 00 07 2202 0000000100000007")
    assert FRAMED[88:112] == bytes.fromhex("affec0c2 00000058 0000002c 00 07 2202 0000000100000007")
    assert _read(tmp_path, FRAMED) == list(map(encode, MESSAGES))


def test_messages_of_other_types_are_skipped(tmp_path):
    assert _read(tmp_path, OTHER + FRAMED + OTHER) == list(map(encode, MESSAGES))


@pytest.mark.parametrize(
    ("data", "words"),
    [
        (b"", "offset 0: expected a scan message of type 0x2202, found none"),
        (OTHER, "offset 0: expected a scan message of type 0x2202, found none"),
        (b"lidar", "message at offset 0: .* found 5"),
        (bytes(100), "message at offset 0: offset 22: .* found 0"),
        (PLAIN[:-1], "message at offset 108: offset 28: 3 points declared, expected 74 bytes, found 73"),
        (PLAIN + bytes(3), "message at offset 182: offset 0: .* found 3"),
        (FRAMED[:-1], "message at offset 156: offset 28: 3 points declared, expected 74 bytes, found 73"),
        (FRAMED[:30], "message at offset 0: offset 0: .* found 6"),
        (FRAMED + FRAMED[:20], "offset 254: expected 24 bytes of data header, found 20; the file is cut off"),
        (OTHER[:-1], "offset 0: expected 3 bytes after the data header of type 0x2030, found 2; the file is cut off"),
    ],
)
def test_an_error_names_the_file_and_the_offset(tmp_path, data, words):
    with pytest.raises(ValueError, match=rf"scans\.bin: {words}"):
        _read(tmp_path, data)


def test_only_the_last_message_may_be_a_fragment(tmp_path):
    *whole, cut = _read(tmp_path, PLAIN[:-1], fragment=True)
    assert whole == list(map(encode, MESSAGES[:2]))
    assert cut == encode(MESSAGES[2])[:-1]
    short = FRAMED[:8] + (44).to_bytes(4, "big") + FRAMED[12:68] + FRAMED[88:]
    with pytest.raises(ValueError, match=r"message at offset 0: offset 28: 2 points declared"):
        _read(tmp_path, short, fragment=True)


def test_the_fragment_of_a_real_scan_is_a_stream_of_one_message():
    path = real_file("lux/scan_0x2202.bin")
    (message,) = read_stream(path, fragment=True)
    assert encode(message) == path.read_bytes()
    with pytest.raises(ValueError, match="message at offset 0: offset 28: 740 points declared"):
        list(read_stream(path))
