"""Start `propmap explore` in a separate process, and open its page in a real browser."""

from __future__ import annotations

import contextlib
import re
import shutil
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Page

BROWSERS = ("chromium", "chromium-browser", "google-chrome")


def browser_path() -> str | None:
    """Where a browser is, None where there is none."""
    return next((path for name in BROWSERS if (path := shutil.which(name))), None)


@contextlib.contextmanager
def explorer(
    *arguments: str, folder: Path | None = None
) -> Iterator[tuple[str, subprocess.Popen[str]]]:
    """Address and process of ``propmap explore`` with these ``arguments``, run in ``folder``."""
    command = [sys.executable, "-m", "propmap", "explore", *arguments, "--no-browser"]
    if "--port" not in arguments:
        command += ["--port", "0"]
    process = subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, cwd=folder
    )
    try:
        yield _address(process), process
    finally:
        if process.poll() is None:
            process.send_signal(signal.SIGINT)
            with contextlib.suppress(subprocess.TimeoutExpired):
                process.wait(10.0)
        if process.poll() is None:
            process.kill()
        if process.stdout is not None:
            process.stdout.close()


def _address(process: subprocess.Popen[str]) -> str:
    assert process.stdout is not None
    said = []
    for line in process.stdout:
        said.append(line)
        found = re.search(r"http://\S+", line)
        if found:
            return found[0].rstrip("/")
    raise RuntimeError("propmap explore did not start: " + "".join(said))


@contextlib.contextmanager
def browser() -> Iterator[Browser]:
    """A browser without a window."""
    from playwright.sync_api import sync_playwright

    with sync_playwright() as driver:
        found = driver.chromium.launch(
            executable_path=browser_path(),
            args=["--no-sandbox", "--disable-dev-shm-usage", "--disable-gpu"],
        )
        try:
            yield found
        finally:
            found.close()


def open_view(page: Page, address: str, within: float = 60.0) -> None:
    """Open an address, until its figures and its table are there."""
    page.goto(address, timeout=1e3 * within)
    page.wait_for_selector(".view", timeout=1e3 * within)
    if page.locator(".place:not([hidden])").count():
        page.wait_for_selector(".js-plotly-plot .main-svg", timeout=1e3 * within)
    settle(page, within)


def settle(page: Page, within: float = 60.0) -> None:
    """Wait until all that was asked for is there."""
    page.wait_for_function("window.propmap && window.propmap.quiet()", timeout=1e3 * within)
