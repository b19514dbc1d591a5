"""Entry point of ``python -m propmap``."""

from __future__ import annotations

import sys

from propmap.cli import main

sys.exit(main())
