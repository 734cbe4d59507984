"""A server of the explorer in a thread, and requests on a socket of it."""

import json
from collections.abc import Callable, Iterator
from typing import Any

import pytest

from restitution.explorer import answers
from restitution.explorer.launch import Running, in_thread, listen
from sockets import opened


@pytest.fixture(scope="package")
def running() -> Iterator[Running]:
    # A first solve compiles, on a slow machine for longer than the sockets of the tests wait.
    for answer in answers.KINDS.values():
        answer({})
    server = listen(port=0)
    thread = in_thread(server)
    yield server
    server.stop()
    thread.join(60.0)
    assert not thread.is_alive()


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
