"""The server of the explorer: one page, its files, and one socket for all that is computed, with its messages."""

from __future__ import annotations

import asyncio
import base64
import json
import math
import secrets
import time
from collections.abc import Callable, Mapping
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from dataclasses import dataclass, field
from functools import cache
from importlib.metadata import version
from importlib.resources import files
from ipaddress import ip_address
from typing import TYPE_CHECKING, Any, NamedTuple, Never
from urllib.parse import urlsplit

import numpy as np

from restitution.errors import InputError
from restitution.explorer import answers, downloads, dropped_files
from restitution.explorer.inputs import PRESETS, State, describe, drop_height, inputs, one_line
from restitution.impact.status import SolverError
from restitution.indentation.tapping import COLUMNS
from restitution.parallel import ended_by
from restitution.quantities import (
    ADHESION,
    BOUNCES,
    HISTORY,
    INDENTATION,
    INPUTS,
    MODULI,
    OBLIQUE,
    OUTPUTS,
    VALIDITY,
    Quantity,
)
from restitution.units import ENERGY, LENGTH, MODULUS, NUMBER, TIME, display_systems

if TYPE_CHECKING:
    from starlette.requests import Request as HttpRequest
    from starlette.types import ASGIApp
    from starlette.websockets import WebSocket

LONGEST = 65_536
"""Most characters of a message without a file."""

LONGEST_FILE_MESSAGE = LONGEST + (4 * dropped_files.LONGEST) // 3
"""Most characters of a message with files, whose bytes are in base64."""

BUG = "this is a mistake in the program; please report it"

_LONGEST_ID = 64

LONGEST_WORK = 5.0
"""Time [s] after which long work on one answer ends."""

# The same where a newer request of the kind waits, and most of what counts between two checks: more is compilation.
_REPLACED, _BETWEEN = 0.5, 1.0
_COMMANDS = {"tapping": "tap", "indentation": "indent"}
_GROUPS = {
    "material": "Material", "body": "Body", "target": "Target", "impact": "Impact", "bounces": "Bounces",
    "indentation": "Indentation", "tapping": "Tapping",
}  # fmt: skip


class _Ended(Exception):
    """The work on a request was ended: no solver takes this for an error of its own."""


class Request(NamedTuple):
    """A request of the page."""

    id: int | float | str | None
    kind: str
    content: Mapping[str, Any]


def _refuse(rule: str, field: str = "message") -> Never:
    raise InputError(field, rule=rule)


def read(text: str | None) -> Request:
    """Return the request of a message; an `InputError` refuses what is none."""
    if text is None:
        _refuse("must be text")
    if len(text) > LONGEST_FILE_MESSAGE:
        _refuse(f"has {len(text)} characters: must have at most {LONGEST_FILE_MESSAGE}")
    try:
        content = json.loads(text, parse_constant=lambda name: _refuse(f"{name} is no number"))
    except (ValueError, RecursionError) as error:
        if isinstance(error, InputError):
            raise
        raise InputError("message", rule="must be JSON") from None
    if not isinstance(content, dict):
        _refuse("must be an object")
    name, kind = content.get("id"), content.get("kind")
    if not (name is None or _is_id(name)):
        _refuse("must be a finite number or a short text", "id")
    if not isinstance(kind, str) or kind not in _KINDS:
        _refuse(f"must be one of {', '.join(_KINDS)}", "kind")
    if kind != "file" and len(text) > LONGEST:
        _refuse(f"has {len(text)} characters: must have at most {LONGEST}")
    if not isinstance(content.get("state", {}), dict):
        _refuse("must be an object", "state")
    return Request(name, kind, content)


def number_of(text: str | None) -> Any:
    """Return the number of a message that could not be read, if it has one."""
    try:
        number = json.loads(text or "")["id"]
    except (ValueError, RecursionError, KeyError, TypeError):
        return None
    return number if _is_id(number) else None


def _is_id(value: Any) -> bool:
    """Return whether an answer can repeat a value as the number of its request."""
    if isinstance(value, bool) or not isinstance(value, int | float | str) or len(str(value)) > _LONGEST_ID:
        return False
    return isinstance(value, str) or math.isfinite(value)


def answer(request: Request) -> str:
    """Return the answer to a request as JSON; one that fails has its reason in one line."""
    started = time.thread_time()
    try:
        # Extreme numbers overflow on their way to a status or a refusal.
        with np.errstate(all="ignore"):
            content = _KINDS[request.kind](request.content)
        content = {"ok": True, "cost": time.thread_time() - started} | content
    except InputError as error:
        content = refusal(error)
    except SolverError as error:
        content = {"ok": False, "error": _line(error), "field": None}
    except (ValueError, ArithmeticError, MemoryError, RuntimeError) as error:
        reason = _line(error)[:200] or type(error).__name__
        content = {"ok": False, "error": f"cannot be computed: {reason}", "field": None}
    return json.dumps({"id": request.id, "kind": request.kind} | content, allow_nan=False, default=_doubles)


def _line(error: Exception) -> str:
    return " ".join(str(error).split())


def _doubles(values: np.ndarray) -> dict[str, str]:
    """Return the numbers in base64, little-endian, which take a tenth of the time of decimals."""
    return {"doubles": base64.b64encode(values.astype("<f8").tobytes()).decode("ascii")}


def refusal(error: InputError) -> dict[str, Any]:
    """Return the part of an answer that names a wrong input."""
    return {"ok": False, "error": one_line(error), "field": error.field if error.field in inputs() else None}


_KINDS: dict[str, Callable[[Mapping[str, Any]], dict[str, Any]]] = {
    **{name: lambda content, kind=kind: kind(content.get("state", {})) for name, kind in answers.KINDS.items()},
    "paper": lambda _: answers.paper(),
    "file": dropped_files.read,
    "download": downloads.download,
}


def schema(state: State | None = None, title: str | None = None) -> str:
    """Return the message at connect: everything that the page may ask for and show, and the state at the start."""
    return json.dumps({"kind": "schema"} | _about() | {"state": state or {}, "title": title}, allow_nan=False)


_FURTHER = (
    Quantity("turning_time", TIME, "time of the largest depth", "t_m"),
    Quantity("contact_end_time", TIME, "end of the contact", "t_end"),
    *(INDENTATION[name] for name in ("work", "dissipated", "stored")),
    Quantity("free_amplitude", LENGTH, "amplitude without a surface", "A_0"),
    COLUMNS["dissipated"]._replace(name="loss_per_tap"),
    Quantity("zone_radius", LENGTH, "outer radius of the attracted ring", "c"),
    Quantity("jump_energy", ENERGY, "energy lost in jumps", "E_j"),
    Quantity("relaxation_modulus", MODULUS, "reduced relaxation modulus", "E*(t)"),
    Quantity("shear_modulus", MODULUS, "relaxation modulus in shear", "G(t)"),
    INPUTS["poisson_ratio"]._replace(name="nu"),
    Quantity("doubtful", NUMBER, "an assumption is doubtful"),
    Quantity("displacement", LENGTH, "displacement of the surface", "w"),
    Quantity("total_time", TIME, "time of the last touch", "t"),
    Quantity("n_bounces", NUMBER, "number of bounces", "n"),
    Quantity("bounce", NUMBER, "bounce", "n"),
)


@cache
def _about() -> dict[str, Any]:
    height = drop_height()
    registries = COLUMNS | ADHESION | INPUTS | MODULI | BOUNCES | dict(VALIDITY) | HISTORY | OBLIQUE | OUTPUTS
    registries |= {quantity.name: quantity for quantity in (*_FURTHER, height.quantity) if quantity is not None}
    registries |= answers.mode_swings()
    quantities = [*(control.quantity for control in inputs().values()), *registries.values()]
    return {
        "version": version("restitution"),
        "inputs": [control.describe() for control in inputs().values()],
        "drop_height": height.describe(),
        "groups": [{"name": name, "words": words} for name, words in _GROUPS.items()],
        "outputs": {name: describe(quantity) for name, quantity in registries.items()},
        "units": display_systems(quantity.dimension for quantity in quantities if quantity is not None),
        "presets": [{"name": name, "words": words, "state": state} for name, (words, state) in PRESETS.items()],
        "limits": {"file_bytes": dropped_files.LONGEST},
    }


_TOO_LONG = 1009
# Kinds of requests that follow a slider, and the time [s] for which each may wait while others go first.
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
        # What cannot be sent to the page is lost.
        with suppress(WebSocketDisconnect, RuntimeError, OSError):
            await self._websocket.send_text(schema)
            await self._read()
        answers.cancel()
        with suppress(asyncio.CancelledError, WebSocketDisconnect, RuntimeError, OSError):
            await answers

    async def _read(self) -> None:
        while (message := await self._websocket.receive())["type"] != "websocket.disconnect":
            text = message.get("text")
            if text is not None and len(text) > LONGEST_FILE_MESSAGE:
                await self._websocket.close(_TOO_LONG)
                return
            try:
                request = read(text)
            except InputError as error:
                answer = {"id": number_of(text), "kind": None} | refusal(error)
                await self._websocket.send_text(json.dumps(answer))
                continue
            quick = request.kind in _QUICK
            # A newer request takes the place of the request that it replaces.
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
                work = loop.run_in_executor(
                    _POOLS[quick],
                    lambda kind=kind: _answered(waiting.pop(kind)[1], lambda: kind in waiting),
                )
                if (text := await work) is not None:
                    await self._websocket.send_text(text)


def _limit(kind: str, is_replaced: Callable[[], bool]) -> Callable[[], None]:
    """Return a check that ends long work on a request; the time of compilation does not count."""
    worked, last, command = 0.0, math.inf, _COMMANDS.get(kind, "solve")

    def check() -> None:
        nonlocal worked, last
        now = time.monotonic()
        worked, last = worked + min(max(now - last, 0.0), _BETWEEN), now
        if worked > _REPLACED and is_replaced():
            raise _Ended
        if worked > LONGEST_WORK:
            raise _Ended(f"takes over {LONGEST_WORK:g} s with these inputs; `restitution {command}` has no limit")

    return check


def _answered(request: Request, is_replaced: Callable[[], bool]) -> str | None:
    """Return the answer to a request, whatever happens: a mistake of the program must not end the session.

    A request that a newer one of its kind replaced has none.
    """
    try:
        with ended_by(_limit(request.kind, is_replaced)):
            return answer(request)
    except _Ended as end:
        if not end.args:
            return None
        return json.dumps({"id": request.id, "kind": request.kind} | refusal(InputError(request.kind, rule=str(end))))
    except Exception as error:
        words = f"{type(error).__name__}: {_line(error)[:200]}; {BUG}"
        return json.dumps({"id": request.id, "kind": request.kind, "ok": False, "error": words, "field": None})


_TYPES = {
    ".html": "text/html; charset=utf-8", ".css": "text/css; charset=utf-8", ".js": "text/javascript; charset=utf-8",
    ".json": "application/json", ".svg": "image/svg+xml", ".txt": "text/plain; charset=utf-8", ".woff2": "font/woff2",
}  # fmt: skip
INDEX = "index.html"
INTERPOLANT = "interpolant.json"

MOST_SOCKETS = 200
"""Pages that are served at a time."""

_REFUSED = 1008


def page_files() -> dict[str, bytes]:
    """Return the files of the page by name: a fixed list, and nothing else is ever served."""
    folder = files("restitution.explorer") / "page"
    return {
        file.name: file.read_bytes()
        for file in sorted(folder.iterdir(), key=lambda file: file.name)
        if file.is_file() and any(file.name.endswith(end) for end in _TYPES)
    }


def content_type(name: str) -> str:
    """Return the type of a file of the page."""
    return next((kind for end, kind in _TYPES.items() if name.endswith(end)), "application/octet-stream")


@dataclass(frozen=True)
class Access:
    """Who may use the server: whoever has the token, under a name that no foreign page can take.

    A page of another site can point a name of its own at this machine. Names are therefore refused, apart from
    `localhost` and the host that was asked for; addresses are not names.
    """

    host: str = "127.0.0.1"
    framed: bool = False
    token: str = field(default_factory=lambda: secrets.token_urlsafe(16))

    def allows_host(self, header: str) -> bool:
        """Return whether the header `Host` names this server."""
        try:
            parts = urlsplit(f"//{header}")
        except ValueError:
            return False
        # A user or a path before or after the name is no part of the header.
        if not header.isprintable() or any(sign in header for sign in "@/?#\\ "):
            return False
        name = parts.hostname or ""
        if name in ("localhost", self.host.lower()):
            return True
        try:
            return bool(ip_address(name))
        except ValueError:
            return False

    def allows_origin(self, origin: str, host: str) -> bool:
        """Return whether a socket is opened by a page of this server."""
        try:
            parts = urlsplit(origin)
        except ValueError:
            return False
        return parts.scheme in ("http", "https") and parts.netloc.lower() == host.lower()

    def allows_tokens(self, tokens: list[str]) -> bool:
        """Return whether the tokens of an address are the right one alone; takes the same time for all wrong ones."""
        return len(tokens) == 1 and secrets.compare_digest(tokens[0].encode(), self.token.encode())

    def headers(self, host: str) -> dict[str, str]:
        """Return the headers of every answer."""
        frames = "http://localhost:* http://127.0.0.1:*" if self.framed else "'none'"
        policy = (
            "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data: blob:; font-src 'self'; "
            f"connect-src 'self' ws://{host} wss://{host}; base-uri 'none'; form-action 'none'; "
            f"frame-ancestors {frames}"
        )
        return {
            "content-security-policy": policy,
            "x-content-type-options": "nosniff",
            "referrer-policy": "no-referrer",
            "cross-origin-resource-policy": "same-origin",
            "cache-control": "no-store",
        }


def application(access: Access, state: State | None = None, title: str | None = None) -> ASGIApp:
    """Return the web application, whose page starts from a state."""
    from starlette.applications import Starlette
    from starlette.responses import PlainTextResponse, Response
    from starlette.routing import Route, WebSocketRoute

    served = page_files()
    about = schema(state, title)

    async def page(request: HttpRequest) -> Response:
        if not access.allows_tokens(request.query_params.getlist("token")):
            return PlainTextResponse("the address has no valid token; open the address that the terminal shows\n", 403)
        return Response(served[INDEX], media_type=content_type(INDEX))

    async def static(request: HttpRequest) -> Response:
        name = request.path_params["name"]
        if name == INTERPOLANT:
            return Response(answers.interpolant(), media_type=content_type(name))
        if name not in served:
            return PlainTextResponse("no such file\n", 404)
        return Response(served[name], media_type=content_type(name))

    opened: set[WebSocket] = set()

    async def socket(websocket: WebSocket) -> None:
        origin = websocket.headers.get("origin", "")
        right = access.allows_origin(origin, websocket.headers.get("host", ""))
        right = right and access.allows_tokens(websocket.query_params.getlist("token"))
        if not right or len(opened) >= MOST_SOCKETS:
            await websocket.close(_REFUSED)
            return
        opened.add(websocket)
        try:
            await Session(websocket).run(about)
        finally:
            opened.discard(websocket)

    routes = [Route("/", page), Route("/static/{name}", static), WebSocketRoute("/ws", socket)]
    return _guarded(Starlette(routes=routes), access)


def _guarded(app: ASGIApp, access: Access) -> ASGIApp:
    """Return an application that refuses foreign names of the server, and adds the headers of every answer."""
    from starlette.responses import PlainTextResponse

    async def call(scope: Any, receive: Any, send: Any) -> None:
        host = next((value.decode("latin-1") for name, value in scope["headers"] if name == b"host"), "")
        if not access.allows_host(host):
            if scope["type"] == "websocket":
                await send({"type": "websocket.close", "code": _REFUSED, "reason": ""})
                return
            await PlainTextResponse("this server does not go by that name\n", 403)(scope, receive, send)
            return
        headers = [(name.encode(), value.encode("latin-1")) for name, value in access.headers(host).items()]

        async def send_with_headers(message: Any) -> None:
            if message["type"] == "http.response.start":
                message = {**message, "headers": [*message.get("headers", []), *headers]}
            await send(message)

        await app(scope, receive, send_with_headers)

    return call
