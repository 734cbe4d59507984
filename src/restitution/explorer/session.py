"""One socket: requests come in, the newest of each kind is answered."""

from __future__ import annotations

import asyncio
import json
import time
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from typing import TYPE_CHECKING

from restitution.errors import InputError
from restitution.explorer import messages
from restitution.explorer.messages import Request

if TYPE_CHECKING:
    from starlette.websockets import WebSocket

_TOO_LONG = 1009
# Kinds that follow a slider, and the time [s] for which one of them may wait while another one goes first.
_QUICK = {"impact": 0.0, "velocity": 0.1}
# One thread has all of them: two would spend a third of their time on waiting for the interpreter's lock.
_POOLS = {True: ThreadPoolExecutor(1), False: ThreadPoolExecutor(2)}


class Session:
    """A socket of one page.

    Requests wait while one is answered; those of quick kinds wait for each other alone. A request that waits is
    replaced by a newer one of its kind, so that the answers never lag behind a slider, and no more than one of each
    kind waits. The pages take turns.
    """

    def __init__(self, websocket: WebSocket) -> None:
        self._websocket = websocket
        # By kind: when its turn is due, and the request.
        self._waiting: dict[bool, dict[str, tuple[float, Request]]] = {quick: {} for quick in _POOLS}
        self._arrived = {quick: asyncio.Event() for quick in _POOLS}

    async def run(self, schema: str) -> None:
        """Serve the socket until it closes."""
        from starlette.websockets import WebSocketDisconnect

        await self._websocket.accept()
        answers = asyncio.gather(*map(self._answer, _POOLS))
        # What the page cannot be sent any more is lost.
        with suppress(WebSocketDisconnect, RuntimeError, OSError):
            await self._websocket.send_text(schema)
            await self._read()
        answers.cancel()
        with suppress(asyncio.CancelledError, WebSocketDisconnect, RuntimeError, OSError):
            await answers

    async def _read(self) -> None:
        while (message := await self._websocket.receive())["type"] != "websocket.disconnect":
            text = message.get("text")
            if text is not None and len(text) > messages.LONGEST_FILE_MESSAGE:
                await self._websocket.close(_TOO_LONG)
                return
            try:
                request = messages.read(text)
            except InputError as error:
                answer = {"id": messages.number_of(text), "kind": None} | messages.refusal(error)
                await self._websocket.send_text(json.dumps(answer))
                continue
            quick = request.kind in _QUICK
            # A newer request keeps the place of the one that it replaces.
            due, _ = self._waiting[quick].get(request.kind, (time.monotonic() + _QUICK.get(request.kind, 0.0), None))
            self._waiting[quick][request.kind] = due, request
            self._arrived[quick].set()

    async def _answer(self, quick: bool) -> None:
        loop, waiting = asyncio.get_running_loop(), self._waiting[quick]
        while True:
            await self._arrived[quick].wait()
            self._arrived[quick].clear()
            while waiting:
                kind = min(waiting, key=lambda kind: waiting[kind][0])
                # The newest request of the kind when its turn comes.
                work = loop.run_in_executor(_POOLS[quick], lambda kind=kind: _answered(waiting.pop(kind)[1]))
                await self._websocket.send_text(await work)


def _answered(request: Request) -> str:
    """Return the answer to a request, whatever happens: the requests after it must be answered too."""
    try:
        return messages.answer(request)
    except Exception as error:
        return json.dumps(messages.failure(request.id, request.kind, error))
