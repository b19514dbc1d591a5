"""Sphinx extension that runs `make reproduce` in parallel with the build.

Only one page needs the results, and the command takes as long as all cells of the other pages.
"""

from __future__ import annotations

import subprocess
from pathlib import Path
from typing import Any

from tools import docs_reproduce

PAGE = "validation"
"""Page that includes the results, read late because Sphinx reads pages in alphabetical order."""

GENERATED = Path(__file__).resolve().parent.parent / "generated"


def setup(app: Any) -> dict[str, Any]:
    """Start the command with the build, and wait for it at the page that includes its results."""
    running: list[subprocess.Popen[bytes]] = []
    # Sphinx checks the folders that it copies before it emits the first event.
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
