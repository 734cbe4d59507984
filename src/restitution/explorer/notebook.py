"""The explorer in a notebook: a frame on a server in a thread of this process."""

from __future__ import annotations

from html import escape
from os import PathLike
from threading import Thread
from typing import TYPE_CHECKING, Self

from restitution.case.impact import Case
from restitution.errors import InputError
from restitution.files import path_of

if TYPE_CHECKING:
    from pathlib import Path

    from restitution.explorer.launch import Running
    from restitution.impact.problem import Impact


class Explorer:
    """A page on a server of its own, at `address`; a notebook shows it in a frame.

    The server ends with `close`, with the end of a `with` block, or with the process.
    """

    def __init__(self, running: Running, thread: Thread, height: int) -> None:
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
        """End the server; the page stays as it is, and computes nothing any more."""
        self._running.stop()
        self._thread.join(10.0)

    def __enter__(self) -> Self:
        """Return the explorer."""
        return self

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
    """Page on which every input of an impact is a slider and every picture follows.

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
    from restitution.checks import whole
    from restitution.explorer.launch import in_thread, listen, warm_up
    from restitution.explorer.state import of_case, of_file, of_impact

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
