"""`python -m scenarios`, the same as `luxloop`."""

import sys

from scenarios.cli import main

sys.exit(main())
