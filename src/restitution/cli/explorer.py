"""The command `explore`: the page with sliders, or its static build."""

from __future__ import annotations

import gc
import os
import sys
import threading
from contextlib import suppress
from pathlib import Path
from typing import Annotated

import typer

from restitution.cli import terminal as cli
from restitution.cli.terminal import argument, option

_LOCAL = ("127.0.0.1", "localhost", "::1")


def explore(
    case: Annotated[
        Path | None, argument("CASE.toml", "Case file, of an impact or an indentation, from which the page starts.")
    ] = None,
    host: Annotated[
        str,
        option("Address to listen on, 127.0.0.1 if not given; 0.0.0.0 opens the page to all who reach this machine."),
    ] = "127.0.0.1",
    port: Annotated[int | None, option("Port to listen on, 8737 if not given; 0 for any free one.", min=0)] = None,
    no_browser: Annotated[bool, typer.Option("--no-browser", help="Print the address and open no browser.")] = False,
    static: Annotated[
        Path | None, option("Write a page on the paper's problem that needs no server, and end.", "DIR")
    ] = None,
) -> None:
    """Open a page in the browser on which every input is a slider and every picture follows.

    Example: restitution explore examples/rubber_ball.toml
    """
    if static is not None:
        _write(static, case)
        return
    # NumPy reads it when it loads: two threads for products of small matrices take more time than one.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    with cli.user_input():
        from restitution.explorer.launch import PORT, listen, warm_up
        from restitution.explorer.states import of_file

        state, title = ({}, None) if case is None else of_file(case)
        running = listen(state, title, host=host, port=PORT if port is None else port)
        with cli.compilation():
            warm_up()
        # What is loaded stays; a search for garbage in it would hold an answer up.
        gc.freeze()
    if host not in _LOCAL:
        cli.report("note", f"--host {host}: everyone who can reach this machine and has the address can use the page")
    print(running.address, flush=True)
    print("Ctrl-C ends the server", file=sys.stderr, flush=True)
    if not no_browser:
        import webbrowser

        # The browser may take a while to return.
        threading.Thread(target=webbrowser.open, args=(running.address,), daemon=True).start()
    # The way in which a server ends is no error.
    with suppress(KeyboardInterrupt):
        running.serve()


def _write(folder: Path, case: Path | None) -> None:
    with cli.user_input():
        from restitution.explorer.launch import write_static

        if case is not None:
            raise cli.BadInput(f"--static {folder}: has the paper's problem alone; leave {case} out")
        written = write_static(folder)
    print(f"{len(written)} files in {folder}; any web server, or the documentation, can hold them")
