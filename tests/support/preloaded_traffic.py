"""Reports when it is imported, for a process that is started early."""

import os
from pathlib import Path

Path(os.environ["PRELOADED_REPORT"]).write_text(str(os.getpid()))
