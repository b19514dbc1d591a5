"""Identification of the catalogue as whole processes: on one core, on all, on two workers."""

from __future__ import annotations

import os
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

DATA = Path(__file__).parents[2] / "shared" / "data" / "uiuc" / "loads.csv"


def catalogue(every: int = 1) -> dict[str, Any]:
    """Time `python -m tools.catalogue` on one core, on all, and by two workers.

    One propeller in ``every`` is taken.
    """
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        rows = DATA.read_text(encoding="utf-8").splitlines()
        names = list(dict.fromkeys(row.partition(",")[0] for row in rows[1:]))
        data = _rows(folder / "loads.csv", rows, names[::every])
        found: dict[str, Any] = {}
        contents = []
        for who, cluster, prepared in (
            ("one_core", [], _on_one_core),
            ("one_process", [], None),
            ("local_2", ["--cluster", "local:2"], None),
        ):
            found[who], content = _identified(data, folder / who, cluster, prepared)
            contents.append(content)
    found["propellers"] = contents[0][0].count(b"\n") - 1
    found["same_bytes"] = contents[0] == contents[1] == contents[2]
    for other in ("one_core", "one_process"):
        found[f"speed_up_over_{other}"] = found[other]["wall_s"] / found["local_2"]["wall_s"]
    return found


def _on_one_core() -> None:
    os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})


def _rows(path: Path, rows: list[str], names: list[str]) -> Path:
    kept = [rows[0], *(row for row in rows[1:] if row.partition(",")[0] in names)]
    path.write_text("\n".join(kept) + "\n", encoding="utf-8")
    return path


def _identified(
    data: Path, folder: Path, cluster: list[str], prepared: Callable[[], None] | None = None
) -> tuple[dict[str, float], list[bytes]]:
    """Times [s] and what the files hold."""
    folder.mkdir()
    output = folder / "identified.csv"
    command = [sys.executable, "-m", "tools.catalogue", str(data), "-o", str(output)]
    before, start = _processor(), time.perf_counter()
    subprocess.run([*command, *cluster], check=True, capture_output=True, preexec_fn=prepared)
    times = {"wall_s": time.perf_counter() - start, "processor_s": _processor() - before}
    files = [path.read_bytes() for path in sorted(folder.iterdir())]
    return times, files


def _processor() -> float:
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime
