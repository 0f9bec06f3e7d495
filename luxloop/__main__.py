"""`python -m luxloop`, the same as `luxloop`."""

import sys

from luxloop.scenarios.cli import main

sys.exit(main())
