"""What holds for all tests."""

import signal

# Shells start background jobs with SIGINT ignored, which all their children inherit; tests press Ctrl-C.
signal.signal(signal.SIGINT, signal.default_int_handler)
