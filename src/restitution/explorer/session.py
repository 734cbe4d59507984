"""One socket: requests come in, the newest of each kind is answered."""

from __future__ import annotations

import asyncio
import json
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from typing import TYPE_CHECKING

from restitution.errors import InputError
from restitution.explorer import messages
from restitution.explorer.messages import Request

if TYPE_CHECKING:
    from starlette.websockets import WebSocket

_TOO_LONG = 1009
# Solves at a time; those of further clients wait.
_POOL = ThreadPoolExecutor(4, thread_name_prefix="explorer")


class Session:
    """A socket of one page.

    Requests wait while one is answered. A request that waits is dropped when a newer one of its kind arrives, so that
    the answers never lag behind a slider, and no more than one of each kind waits.
    """

    def __init__(self, websocket: WebSocket) -> None:
        self._websocket = websocket
        self._waiting: dict[str, Request] = {}
        self._arrived = asyncio.Event()

    async def run(self, schema: str) -> None:
        """Serve the socket until it closes."""
        from starlette.websockets import WebSocketDisconnect

        await self._websocket.accept()
        answers = asyncio.create_task(self._answer())
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
            self._waiting[request.kind] = request
            self._arrived.set()

    async def _answer(self) -> None:
        loop = asyncio.get_running_loop()
        while True:
            await self._arrived.wait()
            self._arrived.clear()
            while self._waiting:
                # The kind that has waited longest; a newer request keeps the place of the one that it replaces.
                request = self._waiting.pop(next(iter(self._waiting)))
                answer = await loop.run_in_executor(_POOL, messages.answer, request)
                await self._websocket.send_text(answer)
