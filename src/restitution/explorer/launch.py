"""Ways to open the explorer: its server for the command, its frame in a notebook, and its page without a server."""

from __future__ import annotations

import json
import socket
import threading
import time
from collections.abc import Mapping
from contextlib import AbstractContextManager, suppress
from dataclasses import dataclass, field
from html import escape
from importlib.util import find_spec
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any

from restitution.case.impact import Case
from restitution.checks import whole
from restitution.errors import InputError
from restitution.explorer import answers
from restitution.explorer.server import INDEX, INTERPOLANT, MOST_SOCKETS, Access, application, page_files, schema
from restitution.explorer.states import of_case, of_file, of_impact
from restitution.files import path_of, whole_file

if TYPE_CHECKING:
    from uvicorn import Server

    from restitution.impact.problem import Impact

PORT = 8737
"""Port of the command by default."""

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
        raise InputError("", rule='the explorer needs starlette and uvicorn: pip install "restitution[web]"')
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
        advice = f"cannot be listened on at {host} ({reason}); give another port, or 0 for any that is free"
        raise InputError("port", port, advice) from None
    return listener


def warm_up() -> None:
    """Load or compile what the first page needs, and in another thread the rest.

    The compilation of everything takes half a minute to a minute after an installation.
    """
    first, *others = answers.KINDS.values()
    first({})

    def compile_others() -> None:
        for kind in others:
            # Taps take too long for an answer on a slow machine.
            with suppress(InputError):
                kind({})

    threading.Thread(target=compile_others, daemon=True).start()


def in_thread(running: Running) -> threading.Thread:
    """Serve in another thread; return when the server answers."""
    thread = threading.Thread(target=running.serve, name="restitution explorer", daemon=True)
    thread.start()
    until = time.monotonic() + _STARTING
    while not running.server.started and thread.is_alive() and time.monotonic() < until:
        time.sleep(0.01)
    return thread


class Explorer(AbstractContextManager["Explorer"]):
    """A page on a server of its own, at `address`; a notebook shows it in a frame.

    The server ends with `close`, with the end of a `with` block, or with the process.
    """

    def __init__(self, running: Running, thread: threading.Thread, height: int) -> None:
        self._running, self._thread, self._height = running, thread, height

    @property
    def address(self) -> str:
        """Address of the page, with the token that it needs."""
        return self._running.address

    @property
    def closed(self) -> bool:
        """Whether the server has ended."""
        return not self._thread.is_alive()

    def close(self) -> None:
        """End the server; the page stays as it is, and stops computing."""
        self._running.stop()
        self._thread.join(10.0)

    def __exit__(self, *_: object) -> None:
        """End the server."""
        self.close()

    def __repr__(self) -> str:
        return f"<Explorer: {'closed' if self.closed else self.address}>"

    def _repr_html_(self) -> str:
        address = escape(self.address, quote=True)
        frame = f'<iframe src="{address}" width="100%" height="{self._height}" style="border: 0"></iframe>'
        return f'{frame}<p><a href="{address}" target="_blank" rel="noreferrer">{address}</a></p>'


def explore(
    impact: Impact | Case | str | Path | None = None, *, host: str = "127.0.0.1", port: int = 0, height: int = 900
) -> Explorer:
    """Return the page on which every input of an impact is a slider and every picture follows.

    Parameters
    ----------
    impact : Impact or path-like, optional
        The impact, or the case file of an impact or an indentation, from which the page starts.
    host, port : str, int
        Address on which the server listens; by default this machine alone, and any free port.
    height : int
        Height of the frame in a notebook [pixels].

    Returns
    -------
    Explorer
        A notebook shows it as a frame. It has the `address` and the method `close`.

    Raises
    ------
    InputError
        If the page cannot show the impact, the port is taken, or the libraries of the extra `web` are missing.

    Notes
    -----
    The browser must run on the machine of the notebook, or reach it at `host`. Whoever has the address can use the
    page, which computes impacts and reads no files of the machine.

    Examples
    --------
    >>> import restitution as rs
    >>> rubber = rs.standard_solid(1e6, 1e7, 1e3, poisson_ratio=0.45)
    >>> page = rs.explore(rs.Impact(rubber, rs.Parabola(0.01), mass=0.005, velocity=1.0))  # doctest: +SKIP
    >>> page.close()  # doctest: +SKIP
    """
    title = None
    if impact is None:
        state = {}
    elif isinstance(impact, Case):
        state, title = of_case(impact), impact.title
    elif isinstance(impact, str | PathLike):
        state, title = of_file(path_of(impact, "impact"))
    else:
        state = of_impact(impact)
    whole("height", height, 100, 10_000)
    running = listen(state, title, host=host, port=port, framed=True)
    warm_up()
    thread = in_thread(running)
    if not thread.is_alive():
        raise InputError("port", running.port, "has no server, which did not start")
    return Explorer(running, thread, height)


_LIVE, _STATIC = '<meta name="restitution" content="live">', '<meta name="restitution" content="static">'

# What the interpolant holds for: the tabs, the options that stay, and the inputs on which it does not depend.
_TABS = {"impact", "paper"}
_ONLY = {
    "material.model": "standard_solid", "profile.type": "parabola", "bulk": "poisson_ratio", "target": "half_space",
    "partner": "rigid", "motion": "straight", "sticking": "none",
}  # fmt: skip
_WITHOUT = {"material.density", "impact.external_force", "impact.body_size", "impact.material_of"}


def _reduced(about: Mapping[str, Any]) -> dict[str, Any]:
    """Return the schema of the page without a server."""
    inputs = [row for row in about["inputs"] if _TABS & {*row["tabs"]} and row["key"] not in _WITHOUT]
    for row in inputs:
        if row["key"] in _ONLY:
            row["options"] = [option for option in row["options"] if option["value"] == _ONLY[row["key"]]]
    fixed = {"page.tab": "impact"} | _ONLY
    keys = {row["key"] for row in inputs}
    presets = [
        preset for preset in about["presets"]
        if preset["state"].keys() <= keys and preset["state"].items() <= (preset["state"] | fixed).items()
    ]  # fmt: skip
    return {**about, "inputs": inputs, "presets": presets}


def write_static(folder: str | Path) -> list[Path]:
    """Create a folder and write the page and its data into it; return the files."""
    folder = Path(folder)
    if folder.exists() and not folder.is_dir():
        raise InputError("folder", str(folder), "must be a folder, and is a file")
    (folder / "static").mkdir(parents=True, exist_ok=True)
    served = page_files()
    index = served.pop(INDEX).decode("utf-8").replace(_LIVE, _STATIC)
    contents = {
        INDEX: index.encode("utf-8"),
        **{f"static/{name}": content for name, content in served.items()},
        f"static/{INTERPOLANT}": answers.interpolant().encode("ascii"),
        "static/schema.json": json.dumps(_reduced(json.loads(schema())), allow_nan=False).encode("utf-8"),
        "static/paper.json": json.dumps(answers.paper(), allow_nan=False).encode("utf-8"),
    }
    for name, content in contents.items():
        with whole_file(folder / name) as partial:
            partial.write_bytes(content)
    return [folder / name for name in contents]
