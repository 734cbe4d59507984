"""The server of the explorer: one page, its files, and one socket for all that is computed."""

from __future__ import annotations

import secrets
from dataclasses import dataclass, field
from importlib.resources import files
from ipaddress import ip_address
from typing import TYPE_CHECKING, Any
from urllib.parse import urlsplit

from restitution.explorer import interpolant, messages
from restitution.explorer.state import State

if TYPE_CHECKING:
    from starlette.applications import Starlette
    from starlette.types import ASGIApp

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
    """Files of the page by name: a fixed list, and nothing else is ever served."""
    folder = files("restitution.explorer") / "page"
    return {
        one.name: one.read_bytes()
        for one in sorted(folder.iterdir(), key=lambda one: one.name)
        if one.is_file() and any(one.name.endswith(end) for end in _TYPES)
    }


def content_type(name: str) -> str:
    """Type of a file of the page."""
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
        """Whether the header `Host` names this server."""
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
        """Whether a socket is opened by a page of this server."""
        try:
            parts = urlsplit(origin)
        except ValueError:
            return False
        return parts.scheme in ("http", "https") and parts.netloc.lower() == host.lower()

    def allows_tokens(self, tokens: list[str]) -> bool:
        """Whether the tokens of an address are the right one alone; takes the same time for all wrong ones."""
        return len(tokens) == 1 and secrets.compare_digest(tokens[0].encode(), self.token.encode())

    def headers(self, host: str) -> dict[str, str]:
        """Headers of every answer."""
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


def application(access: Access, state: State | None = None, title: str | None = None) -> Starlette:
    """Return the web application, whose page starts from a state."""
    from starlette.applications import Starlette
    from starlette.middleware import Middleware
    from starlette.requests import Request
    from starlette.responses import PlainTextResponse, Response
    from starlette.routing import Route, WebSocketRoute
    from starlette.websockets import WebSocket

    from restitution.explorer.session import Session

    served = page_files()
    schema = messages.schema(state, title)

    async def page(request: Request) -> Response:
        if not access.allows_tokens(request.query_params.getlist("token")):
            return PlainTextResponse("the address has no valid token; open the one that the terminal shows\n", 403)
        return Response(served[INDEX], media_type=content_type(INDEX))

    async def static(request: Request) -> Response:
        name = request.path_params["name"]
        if name == INTERPOLANT:
            return Response(interpolant.as_json(), media_type=content_type(name))
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
            await Session(websocket).run(schema)
        finally:
            opened.discard(websocket)

    routes = [Route("/", page), Route("/static/{name}", static), WebSocketRoute("/ws", socket)]
    return Starlette(routes=routes, middleware=[Middleware(_Guard, access)])


class _Guard:
    """Refuses foreign names of the server, and adds the headers of every answer."""

    def __init__(self, app: ASGIApp, access: Access) -> None:
        self.app, self.access = app, access

    async def __call__(self, scope: Any, receive: Any, send: Any) -> None:
        if scope["type"] not in ("http", "websocket"):
            await self.app(scope, receive, send)
            return
        host = next((value.decode("latin-1") for name, value in scope["headers"] if name == b"host"), "")
        if not self.access.allows_host(host):
            await self._refuse(scope, receive, send)
            return
        headers = [(name.encode(), value.encode("latin-1")) for name, value in self.access.headers(host).items()]

        async def send_with_headers(message: Any) -> None:
            if message["type"] == "http.response.start":
                message = {**message, "headers": [*message.get("headers", []), *headers]}
            await send(message)

        await self.app(scope, receive, send_with_headers)

    @staticmethod
    async def _refuse(scope: Any, receive: Any, send: Any) -> None:
        from starlette.responses import PlainTextResponse

        if scope["type"] == "websocket":
            await send({"type": "websocket.close", "code": _REFUSED, "reason": ""})
            return
        await PlainTextResponse("this server does not go by that name\n", 403)(scope, receive, send)
