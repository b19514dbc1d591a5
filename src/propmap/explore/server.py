"""The server: where it listens, whom it answers, and how it ends."""

from __future__ import annotations

import contextlib
import errno
import ipaddress
import logging
import os
import sys
import threading
import webbrowser
from collections.abc import Callable, Iterable
from typing import Any

from flask import Flask, Response, request
from werkzeug.serving import BaseWSGIServer, make_server

from propmap.errors import InputError

MOST_BYTES = 8_000_000
"""Of a request: an upload of 5 MB is a third larger on its way."""

LOOPBACK = ("localhost", "127.0.0.1", "[::1]")

PORTS_TRIED = 20


def guard(server: Flask, names: Iterable[str]) -> None:
    """Refuse what is not meant for this server, and what is too large.

    A page of another site that has its name point to this machine sends that name in ``Host``.

    Parameters
    ----------
    server : Flask
        To be guarded.
    names : iterable of str
        What it may be called, without port.
    """
    allowed = {name.lower() for name in names}
    server.config["MAX_CONTENT_LENGTH"] = MOST_BYTES

    @server.before_request
    def _known_host() -> Response | None:
        name = request.host.rpartition(":")[0] if _has_port(request.host) else request.host
        if name.lower() in allowed:
            return None
        return Response("This server does not answer under that name.\n", 403)

    @server.errorhandler(Exception)
    def _told(error: Exception) -> Any:
        code = getattr(error, "code", None)
        if isinstance(code, int):
            return Response(f"{getattr(error, 'name', 'error')}\n", code)
        logging.getLogger(__name__).debug("a request failed", exc_info=error)
        return Response("The request could not be answered.\n", 500)

    @server.after_request
    def _closed(response: Response) -> Response:
        response.headers["X-Content-Type-Options"] = "nosniff"
        response.headers["X-Frame-Options"] = "DENY"
        response.headers["Referrer-Policy"] = "no-referrer"
        response.headers["Content-Security-Policy"] = (
            "default-src 'self' data: blob:; style-src 'self' 'unsafe-inline'; "
            "script-src 'self' 'unsafe-inline' 'unsafe-eval'; frame-ancestors 'none'"
        )
        return response


def _has_port(host: str) -> bool:
    return host.rpartition(":")[2].isdigit() and (host.count(":") == 1 or "]:" in host)


def names_of(host: str) -> set[str]:
    """What a server that listens on ``host`` may be called."""
    found = {*LOOPBACK, host, f"[{host}]"}
    if not is_loopback(host):
        import socket

        found |= {socket.gethostname(), socket.getfqdn()}
        if host in ("0.0.0.0", "::"):
            found |= {info[4][0] for info in _own_addresses(socket.gethostname())}
    return {str(name) for name in found}


def _own_addresses(name: str) -> list[Any]:
    import socket

    try:
        return socket.getaddrinfo(name, None)
    except OSError:
        return []


def is_loopback(host: str) -> bool:
    """Whether ``host`` is this machine alone."""
    if host == "localhost":
        return True
    try:
        return ipaddress.ip_address(host.strip("[]")).is_loopback
    except ValueError:
        return False


def listen(app: Flask, host: str, port: int | None, first: int) -> BaseWSGIServer:
    """A server that listens.

    Parameters
    ----------
    app : Flask
        What it serves.
    host : str
        Where.
    port : int or None
        Asked for; None for ``first`` or the next that is free.
    first : int
        Tried first where none is asked for.

    Raises
    ------
    InputError
        Where the port is taken or may not be used, and where there is no such host.
    """
    tried = [port] if port is not None else list(range(first, first + PORTS_TRIED))
    for one in tried:
        try:
            return _bound(app, host, one)
        except OSError as error:
            if error.errno == errno.EADDRINUSE and one != tried[-1]:
                continue
            if error.errno == errno.EADDRINUSE:
                found = f"port {one} of {host} is in use"
                raise InputError(found, "give another by --port, or end what uses it") from None
            reason = error.strerror or str(error)
            raise InputError(
                f"cannot listen on {host}, port {one}: {reason}", "give another --host or --port"
            ) from None
    raise AssertionError


def _bound(app: Flask, host: str, port: int) -> BaseWSGIServer:
    import socket

    # Bound here: werkzeug would print its own lines and leave the process where a port is taken.
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    listener = socket.socket(family, socket.SOCK_STREAM)
    try:
        listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        listener.bind((host.strip("[]"), port))
        listener.listen(64)
        server = make_server(host.strip("[]"), port, app, threaded=True, fd=listener.fileno())
    finally:
        listener.close()
    return server


def serve(server: BaseWSGIServer, say: Callable[[str], None], *, browser: bool, host: str) -> None:
    """Answer until Ctrl-C, which ends the process's work at once.

    Parameters
    ----------
    server : BaseWSGIServer
        From ``listen``.
    say : callable
        Gets lines for the terminal.
    browser : bool
        Whether one is opened.
    host : str
        As it was asked for.
    """
    logging.getLogger("werkzeug").setLevel(logging.ERROR)
    shown = "127.0.0.1" if host in ("0.0.0.0", "::", "localhost") else host
    address = f"http://{f'[{shown}]' if ':' in shown else shown}:{server.port}/"
    with contextlib.suppress(KeyboardInterrupt):
        say(f"propmap explore is at {address}")
        say("Ctrl-C ends it.")
        if browser:
            threading.Thread(target=_open, args=(address, say), daemon=True).start()
        server.serve_forever()
    # A fit under way is not waited for.
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(0)


def _open(address: str, say: Callable[[str], None]) -> None:
    opened = False
    if sys.platform != "linux" or os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"):
        try:
            opened = webbrowser.open(address)
        except webbrowser.Error:
            opened = False
    if not opened:
        say("There is no display or no browser here: open the address above yourself.")
