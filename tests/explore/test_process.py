"""`propmap explore` as a process: how it begins, and how it ends."""

from __future__ import annotations

import os
import signal
import socket
import subprocess
import sys
import time
import urllib.request

import pytest

from tools.explore_browser import explorer

pytestmark = pytest.mark.slow


def test_ctrl_c_ends_it_at_once_with_exit_code_0() -> None:
    with explorer("apc-8x6e") as (address, process):
        with urllib.request.urlopen(address, timeout=30) as page:
            assert page.status == 200
        time.sleep(2.0)
        begin = time.monotonic()
        process.send_signal(signal.SIGINT)
        assert process.wait(20.0) == 0
        # At once, on a machine that others load.
        assert time.monotonic() - begin < 10.0


def test_no_display_is_told_with_the_address() -> None:
    command = [sys.executable, "-m", "propmap", "explore", "--port", "0"]
    environment = {k: v for k, v in os.environ.items() if k not in ("DISPLAY", "WAYLAND_DISPLAY")}
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True, env=environment) as process:
        try:
            assert process.stdout is not None
            said = ""
            while "no display" not in said and process.poll() is None:
                said += process.stdout.readline()
            assert "http://127.0.0.1:" in said
            process.send_signal(signal.SIGINT)
            assert process.wait(20.0) == 0
        finally:
            process.kill()


def test_what_is_wrong_is_told_before_anything_listens() -> None:
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        for arguments, words in (
            ("missing.toml", "no such file"),
            ("--host no.such.host.example", "cannot listen"),
            (f"--port {taken.getsockname()[1]}", "already in use"),
        ):
            command = [sys.executable, "-m", "propmap", "explore", "--no-browser"]
            done = subprocess.run([*command, *arguments.split()], capture_output=True, text=True)
            assert done.returncode == 2
            assert words in done.stderr.lower() and done.stderr.count("\n") == 1
