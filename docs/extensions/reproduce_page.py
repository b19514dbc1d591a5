"""Runs what `make reproduce` runs beside the build, which needs the results on one page only.

The command takes as long as all the cells of the other pages: side by side they share the cores.
"""

from __future__ import annotations

import subprocess
from pathlib import Path
from typing import Any

from tools import docs_reproduce

PAGE = "validation"
"""The page that includes the results; Sphinx reads pages in the order of their names."""

GENERATED = Path(__file__).resolve().parent.parent / "generated"


def setup(app: Any) -> dict[str, Any]:
    """Start the command with the build, and wait for it where its results are included."""
    running: list[subprocess.Popen[bytes]] = []
    # Sphinx looks for the folders that it copies before anything else happens.
    docs_reproduce.folder_of_page(GENERATED).parent.mkdir(parents=True, exist_ok=True)

    def start(*_: Any) -> None:
        running.append(docs_reproduce.start(GENERATED))

    def outdated(*_: Any) -> list[str]:
        return [PAGE]

    def include(_: Any, name: str, *__: Any) -> None:
        if name == PAGE:
            docs_reproduce.finish(running.pop(), GENERATED)

    def stop(*_: Any) -> None:
        for process in running:
            process.kill()

    app.connect("builder-inited", start)
    app.connect("env-get-outdated", outdated)
    app.connect("source-read", include)
    app.connect("build-finished", stop)
    return {"parallel_read_safe": False, "parallel_write_safe": True}
