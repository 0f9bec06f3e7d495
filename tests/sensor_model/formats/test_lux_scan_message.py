"""Codec of the LUX scan message, against bytes written by hand and the fragment of a real scan."""

import csv
from dataclasses import replace

import hypothesis.strategies as st
import numpy as np
import pytest
from hypothesis import given
from hypothesis.extra import numpy as arrays
from support.real_data import real_file

from luxloop.sensor_model.formats.lux_scan_message import LuxHeader, LuxMessage, decode, encode

HEADER = bytes.fromhex(
    "3930"  # scan number 12345
    "0700"  # status
    "1000"  # sync phase
    "0000008002000000"  # start: 2.5 s
    "0000004003000000"  # end: 3.25 s
    "002d"  # 11520 ticks per turn
    "4006"  # from +50 degrees
    "80f8"  # to -60 degrees
    "0200"  # two points
    "e0ff40000100"  # yaw -1, pitch 2 degrees, roll 1/32 degree
    "6301b5ff3700"  # x 3.55, y -0.75, z 0.55 m
    "0004"  # mirror side
)
POINTS = bytes.fromhex(
    "03054006d204cc000000"  # layer 3, echo 0, transparent and ground, +50 degrees, 12.34 m, 2.04 m
    "12f2fffff4011800cdab"  # layer 2, echo 1, clutter and unknown bits, -1/32 degree, 5 m, 0.24 m, reserved word
)


def test_decode_reads_each_field_of_a_message_written_by_hand():
    message = decode(HEADER + POINTS)
    assert message.header == LuxHeader(
        scan_number=12345,
        scanner_status=7,
        sync_phase=16,
        start_ntp=5 << 31,
        end_ntp=13 << 30,
        ticks_per_turn=11520,
        start_ticks=1600,
        end_ticks=-1920,
        points=2,
        mount_yaw_ticks=-32,
        mount_pitch_ticks=64,
        mount_roll_ticks=1,
        mount_x_cm=355,
        mount_y_cm=-75,
        mount_z_cm=55,
        flags=0x400,
    )
    assert message.complete
    assert message.layer.tolist() == [3, 2]
    assert message.echo.tolist() == [0, 1]
    assert message.flags.tolist() == [5, 0xF2]
    assert message.azimuth_ticks.tolist() == [1600, -1]
    assert message.range_cm.tolist() == [1234, 500]
    assert message.width_cm.tolist() == [204, 24]
    assert message.reserved.tolist() == [0, 0xABCD]
    assert encode(message) == HEADER + POINTS


def test_times_of_points_run_evenly_from_the_start_to_the_end_angle():
    message = decode(HEADER + POINTS)
    assert message.start_s == 2.5
    assert message.duration_s == 0.75
    np.testing.assert_allclose(message.time_offset, [0.0, 0.75 * 1601 / 3520], rtol=1e-12)


@pytest.mark.parametrize(
    ("data", "words"),
    [
        (b"", "offset 0: a scan message starts with 44 bytes of header, found 0"),
        (HEADER[:43], "offset 0: a scan message starts with 44 bytes of header, found 43"),
        (HEADER[:22] + b"\0\1" + HEADER[24:] + POINTS, "offset 22: .* found 256"),
        (HEADER + POINTS[:-1], "offset 28: 2 points declared, expected 64 bytes, found 63"),
        (HEADER + POINTS + b"ab", "offset 64: the message ends here .* found 2 more"),
    ],
)
def test_decode_names_the_offset_of_an_error(data, words):
    with pytest.raises(ValueError, match=words):
        decode(data)


@pytest.mark.parametrize("size", [0, 1, 9, 10, 13, 19, 20])
def test_a_fragment_keeps_its_bytes_and_the_declared_number(size):
    message = decode(HEADER + POINTS[:size], fragment=True)
    assert len(message) == size // 10
    assert message.complete == (size == 20)
    assert message.header.points == 2
    assert encode(message) == HEADER + POINTS[:size]


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda m: replace(m, header=replace(m.header, points=1)), "points = 1 in the header; the message has 2"),
        (lambda m: replace(m, layer=np.array([16, 0], np.uint8)), "layer = 16: must be 0 to 15"),
        (lambda m: replace(m, header=replace(m.header, mount_x_cm=40_000)), "header: "),
    ],
)
def test_encode_refuses_what_does_not_fit(change, words):
    with pytest.raises(ValueError, match=words):
        encode(change(decode(HEADER + POINTS)))


def _words(dtype, count, most=None):
    info = np.iinfo(dtype)
    values = st.integers(info.min, info.max if most is None else most)
    return arrays.arrays(dtype, count, elements=values)


@st.composite
def messages(draw):
    """Any message; its declared number of points may exceed those present."""
    count = draw(st.integers(0, 20))
    u16, i16, u64 = st.integers(0, 2**16 - 1), st.integers(-(2**15), 2**15 - 1), st.integers(0, 2**64 - 1)
    declared = count + draw(st.integers(0, 3))
    header = LuxHeader(
        draw(u16), draw(u16), draw(u16), draw(u64), draw(u64), 11520, draw(i16), draw(i16), declared,
        *(draw(i16) for _ in range(6)), draw(u16),
    )  # fmt: skip
    return LuxMessage(
        header, draw(_words(np.uint8, count, 15)), draw(_words(np.uint8, count, 15)), draw(_words(np.uint8, count)),
        draw(_words(np.int16, count)), draw(_words(np.uint16, count)), draw(_words(np.uint16, count)),
        draw(_words(np.uint16, count)), draw(st.binary(max_size=9)) if declared > count else b"",
    )  # fmt: skip


@given(messages())
def test_decode_inverts_encode(message):
    data = encode(message)
    again = decode(data, fragment=True)
    assert again.header == message.header
    for name in ("layer", "echo", "flags", "azimuth_ticks", "range_cm", "width_cm", "reserved"):
        np.testing.assert_array_equal(getattr(again, name), getattr(message, name))
    assert again.rest == message.rest
    assert encode(again) == data


def test_the_fragment_of_a_real_scan_is_reproduced_byte_by_byte():
    path = real_file("lux/scan_0x2202.bin")
    data = path.read_bytes()
    message = decode(data, fragment=True)
    assert encode(message) == data
    assert (message.header.points, len(message), message.complete) == (740, 139, False)
    with pytest.raises(ValueError, match="740 points declared, expected 7444 bytes, found 1436"):
        decode(data)
    assert message.duration_s == pytest.approx(0.02219, abs=1e-5)
    with path.with_suffix(".csv").open() as file:
        rows = np.array([[float(value) for value in row.values()] for row in csv.DictReader(file)])
    decoded = np.stack(
        [message.layer, message.echo, message.flags, message.azimuth_ticks / 32, message.range_cm / 100,
         message.width_cm / 100], axis=1,
    )  # fmt: skip
    np.testing.assert_allclose(decoded, rows, atol=1e-9)
