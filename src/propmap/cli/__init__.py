"""The command ``propmap``: one module per command, no physics."""

from __future__ import annotations

from propmap.cli.app import main

__all__ = ["main"]
