"""Start and end of the explorer's server: in this thread for the command, in another one for a notebook."""

from __future__ import annotations

import socket
import threading
import time
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from importlib.util import find_spec
from typing import TYPE_CHECKING, Any

from restitution.checks import whole
from restitution.errors import InputError
from restitution.explorer import answers
from restitution.explorer.server import MOST_SOCKETS, Access, application

if TYPE_CHECKING:
    from uvicorn import Server

PORT = 8737
"""Port of the command, unless another one is given."""

# Bytes of a message, and connections at a time: some more than sockets, so that a page can still be loaded.
_LARGEST, _CONNECTIONS = 4_000_000, MOST_SOCKETS + 56
# Seconds that open sockets have to close.
_CLOSING = 1
_STARTING = 10.0


@dataclass
class Running:
    """A server that listens; `serve` answers until it is stopped."""

    access: Access
    port: int
    listener: socket.socket = field(repr=False)
    server: Server = field(repr=False)

    @property
    def address(self) -> str:
        """Address of the page, with the token."""
        name = "127.0.0.1" if self.access.host in ("0.0.0.0", "::", "") else self.access.host
        name = f"[{name}]" if ":" in name else name
        return f"http://{name}:{self.port}/?token={self.access.token}"

    def serve(self) -> None:
        """Answer requests until the server is stopped, in the main thread until Ctrl-C."""
        try:
            self.server.run(sockets=[self.listener])
        finally:
            self.listener.close()

    def stop(self) -> None:
        """End the server, from another thread."""
        self.server.should_exit = True


def listen(
    state: Mapping[str, Any] | None = None,
    title: str | None = None,
    *,
    host: str = "127.0.0.1",
    port: int = PORT,
    framed: bool = False,
    token: str | None = None,
) -> Running:
    """Listen on a port, 0 for any that is free; refuse one that is taken. The token is random unless given."""
    if not all(map(find_spec, ("starlette", "uvicorn", "websockets"))):
        raise InputError("", wanted='the explorer needs starlette and uvicorn: pip install "restitution[web]"')
    from uvicorn import Config, Server

    whole("port", port, 0, 65535)
    listener = _listener(host, port)
    access = Access(host, framed, **({} if token is None else {"token": token}))
    config = Config(
        application(access, dict(state or {}), title), log_level="critical", access_log=False, server_header=False,
        ws_max_size=_LARGEST, ws_max_queue=8, limit_concurrency=_CONNECTIONS, ws_per_message_deflate=False,
        timeout_graceful_shutdown=_CLOSING, lifespan="off",
    )  # fmt: skip
    return Running(access, listener.getsockname()[1], listener, Server(config))


def _listener(host: str, port: int) -> socket.socket:
    try:
        (family, kind, *_, address), *_ = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM)
    except (OSError, UnicodeError):
        raise InputError("host", host, "must be a name or an address of this machine") from None
    listener = socket.socket(family, kind)
    # A port that was used a moment ago may be used again.
    with suppress(OSError):
        listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    try:
        listener.bind(address)
        listener.listen()
    except OSError as error:
        listener.close()
        reason = (error.strerror or str(error)).lower()
        advice = f"cannot be listened on at {host} ({reason}); another one, or 0 for any that is free, may do"
        raise InputError("port", port, advice) from None
    return listener


def warm_up() -> None:
    """Load or compile what the first page needs, and in another thread the rest.

    The compilation of everything takes half a minute to a minute after an installation.
    """
    first, *others = answers.KINDS.values()
    first({})
    threading.Thread(target=lambda: [kind({}) for kind in others], daemon=True).start()


def in_thread(running: Running) -> threading.Thread:
    """Serve in another thread; return when the server answers."""
    thread = threading.Thread(target=running.serve, name="restitution explorer", daemon=True)
    thread.start()
    until = time.monotonic() + _STARTING
    while not running.server.started and thread.is_alive() and time.monotonic() < until:
        time.sleep(0.01)
    return thread
