"""Garbage collection in processes of luxloop."""

import subprocess
import sys

PROGRAM = """
import gc, sys
from luxloop.sim.rare_collection import collect_rarely
class Cycle:
    def __init__(self): self.itself = self
    def __del__(self): sys.stdout.write("collected")
collect_rarely()
keep_out_of_reach = Cycle()
del keep_out_of_reach
"""


def test_a_process_ends_without_a_last_collection():
    """Python would collect the cycle before it ends; with all modules of a run that takes 0.7 s."""
    run = subprocess.run([sys.executable, "-c", PROGRAM], capture_output=True, text=True, check=True)
    assert run.stdout == ""
