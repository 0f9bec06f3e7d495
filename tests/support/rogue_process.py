"""A program that breaks the protocol of trackers in their own process, in the way that its argument names."""

import os
import signal
import struct
import subprocess
import sys
import time

FAULT, scans, results = sys.argv[1], sys.stdin.buffer, sys.stdout.buffer


def answer(frame, tracks=0, body=b""):
    """Write the message of a number of tracks."""
    results.write(struct.pack("<III", 8 + len(body), frame, tracks) + body)
    results.flush()


def misbehave(frame):
    """Break the protocol in place of an answer."""
    match FAULT:
        case "exit 0":
            os._exit(0)
        case "exit 3":
            os._exit(3)
        case "crash":
            os.kill(os.getpid(), signal.SIGSEGV)
        case "hang":
            time.sleep(1e6)
        case "print":
            print("frame", frame, flush=True)
            time.sleep(1e6)
        case "wrong frame":
            answer(frame + 1)
        case "wrong length":
            answer(frame, 2, bytes(65))
        case "nan":
            answer(frame, 1, struct.pack("<q7dB", 1, float("nan"), 0, 0, 4, 2, 0, 0, 1))
        case "children":
            subprocess.Popen(["sleep", "1000.125"])
            time.sleep(1e6)
        case "answers twice":
            answer(frame)
            answer(frame)
        case _:
            answer(frame)


if FAULT == "no greeting":
    sys.exit(0)
results.write(b"Hello!!!" if FAULT == "wrong greeting" else scans.read(8))
results.flush()
if FAULT == "reads nothing":
    time.sleep(1e6)
while head := scans.read(4):
    (frame,) = struct.unpack_from("<I", scans.read(struct.unpack("<I", head)[0]))
    if frame > 3:
        misbehave(frame)
    else:
        answer(frame)
if FAULT == "exit 5 at the end":
    sys.exit(5)
if FAULT == "stays":
    time.sleep(1e6)
