"""A server of the explorer in a thread, and a socket of it."""

import http.client
import json
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import pytest
from websockets.sync.client import ClientConnection, connect

from restitution.explorer.launch import Running, in_thread, listen


@pytest.fixture(scope="package")
def running() -> Iterator[Running]:
    server = listen(port=0)
    thread = in_thread(server)
    yield server
    server.stop()
    thread.join(10.0)
    assert not thread.is_alive()


@contextmanager
def opened(running: Running, **options: Any) -> Iterator[ClientConnection]:
    """Socket of a page of the server; yields it after the schema, which it has as `schema`."""
    here = f"127.0.0.1:{running.port}"
    address = f"ws://{here}/ws?token={running.access.token}"
    settings: Any = {"origin": f"http://{here}", "max_size": None, "compression": None} | options
    with connect(settings.pop("address", address), **settings) as socket:
        socket.schema = json.loads(socket.recv(timeout=30))  # pyright: ignore[reportAttributeAccessIssue]
        yield socket


@pytest.fixture
def ask(running: Running) -> Iterator[Callable[..., dict[str, Any]]]:
    """Function that sends a request of a kind and returns the answer."""
    with opened(running) as socket:

        def ask(kind: str, state: dict[str, Any] | None = None, **further: Any) -> dict[str, Any]:
            socket.send(json.dumps({"id": 1, "kind": kind, "state": state or {}} | further))
            answer = json.loads(socket.recv(timeout=60))
            assert (answer["id"], answer["kind"]) == (1, kind)
            return answer

        yield ask


def get(running: Running, path: str, **headers: str) -> http.client.HTTPResponse:
    """Answer to a GET; the headers replace the usual ones."""
    connection = http.client.HTTPConnection("127.0.0.1", running.port, timeout=10)
    try:
        connection.putrequest("GET", path, skip_host="host" in headers)
        for name, value in headers.items():
            connection.putheader(name, value)
        connection.endheaders()
        answer = connection.getresponse()
        answer.content = answer.read()  # pyright: ignore[reportAttributeAccessIssue]
        return answer
    finally:
        connection.close()
