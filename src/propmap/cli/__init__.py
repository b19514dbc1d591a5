"""Command line of propmap: one module per command, without physics."""

from __future__ import annotations

from propmap.cli.app import main

__all__ = ["main"]
