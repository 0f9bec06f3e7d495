"""The run loop, the device under test and the run folder."""
