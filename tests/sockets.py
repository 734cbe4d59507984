"""A client of the explorer's server: a socket of a page, and single requests."""

import http.client
import json
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from websockets.sync.client import ClientConnection, connect

from restitution.explorer.launch import Running


@contextmanager
def opened(running: Running, **options: Any) -> Iterator[ClientConnection]:
    """Socket of a page of the server; yields it after the schema, which it has as `schema`."""
    here = f"127.0.0.1:{running.port}"
    address = f"ws://{here}/ws?token={running.access.token}"
    settings: Any = {"origin": f"http://{here}", "max_size": None, "compression": None} | options
    with connect(settings.pop("address", address), **settings) as socket:
        socket.schema = json.loads(socket.recv(timeout=30))  # pyright: ignore[reportAttributeAccessIssue]
        yield socket


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
