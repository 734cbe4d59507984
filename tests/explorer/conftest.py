"""A server of the explorer in a thread, requests on a socket of it, and its page in a browser."""

import json
from collections.abc import Callable, Iterator
from contextlib import suppress
from typing import Any
from urllib.parse import urlencode

import pytest

import chromium
import restitution as rs
import sockets
from restitution.explorer import answers
from restitution.explorer.launch import Running, in_thread, listen, warm_up


@pytest.fixture(scope="package")
def running() -> Iterator[Running]:
    # A first solve compiles, on a slow machine for longer than the sockets of the tests wait.
    for answer in answers.KINDS.values():
        # Taps take too long for an answer on a slow machine.
        with suppress(rs.InputError):
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
    with sockets.opened(running) as socket:

        def ask(kind: str, state: dict[str, Any] | None = None, **further: Any) -> dict[str, Any]:
            socket.send(json.dumps({"id": 1, "kind": kind, "state": state or {}} | further))
            answer = json.loads(socket.recv(timeout=60))
            assert (answer["id"], answer["kind"]) == (1, kind)
            return answer

        yield ask


@pytest.fixture(scope="module")
def browser():
    from playwright.sync_api import sync_playwright

    with sync_playwright() as driver:
        browser = driver.chromium.launch(executable_path=chromium.CHROMIUM, args=chromium.OPTIONS)
        yield browser
        browser.close()


@pytest.fixture(scope="module")
def address():
    # A first solve compiles for longer than a page waits.
    warm_up()
    with chromium.serving() as running:
        yield running.address


@pytest.fixture
def opened(browser, address):
    """Open the page with a state; afterwards no error was logged, and every request went to the server."""
    errors, hosts, allowed, contexts = [], set(), {""}, []

    def open_page(state=None, start=address, **options):
        allowed.add(start.split("/")[2])
        context = browser.new_context(**({"reduced_motion": "reduce", "accept_downloads": True} | options))
        contexts.append(context)
        page = context.new_page()
        page.on("console", lambda message: errors.append(message.text) if message.type == "error" else None)
        page.on("pageerror", lambda error: errors.append(str(error)))
        page.on("request", lambda request: hosts.add(request.url.split("/")[2] if "//" in request.url else ""))
        page.goto(start if "#" in start else f"{start}#{urlencode(chromium.BASE | (state or {}))}")
        page.wait_for_selector("[data-output][data-value]:visible, .present p")
        return page

    yield open_page
    for context in contexts:
        context.close()
    assert errors == []
    assert hosts <= allowed
