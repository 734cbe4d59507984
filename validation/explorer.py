"""A random campaign against the explorer's server: messages, names of the machine, origins, tokens, paths, bombs.

Usage: python validation/explorer.py [--messages 12000] [--seed 1] [--out FILE]
"""

from __future__ import annotations

import argparse
import base64
import json
import random
import socket
import string
import sys
import threading
import time
from contextlib import suppress
from pathlib import Path
from typing import Any

from rich.progress import track
from websockets.exceptions import ConnectionClosed, InvalidStatus

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))

import random_messages
from restitution.explorer import launch
from restitution.explorer.server import BUG, MOST_SOCKETS
from sockets import get, opened

PATIENCE = 120.0


def main() -> None:
    """Run all parts and write a table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--messages", type=int, default=12_000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--out", type=Path, default=Path(__file__).with_suffix(".md"))
    options = parser.parse_args()
    running = launch.listen(port=0)
    launch.warm_up()
    launch.in_thread(running)
    rng = random.Random(options.seed)
    rows = [
        ("random messages", bombard(running, rng, options.messages)),
        ("names of the machine", names(running, rng)),
        ("origins", origins(running, rng)),
        ("tokens", tokens(running, rng)),
        ("paths", paths(running, rng)),
        ("bombs", bombs(running)),
        ("half-open requests", half_open(running)),
        ("sockets at a time", crowd(running)),
    ]
    running.stop()
    lines = [f"Seed {options.seed}.", "", "| part | tried | failed | seen |", "|---|---:|---:|---|"]
    lines += [f"| {name} | {tried:,} | {failed} | {words} |" for name, (tried, failed, words) in rows]
    options.out.write_text("\n".join(lines) + "\n", encoding="utf-8")
    sys.exit(any(failed for _, (_, failed, _) in rows))


def works(running: launch.Running) -> bool:
    """Whether a good request is answered."""
    with opened(running) as page:
        page.send(json.dumps({"id": "good", "kind": "impact", "state": {}}))
        return bool(json.loads(page.recv(timeout=PATIENCE))["ok"])


def ids(rng: random.Random) -> str:
    """A number of a request as JSON has it, of use or not."""
    return rng.choice(("1e999", "-1e999", "1e308", "NaN", "null", "true", '"x"', "0.5", "[]", "9" * 80, "1e-400"))


def bombard(running: launch.Running, rng: random.Random, count: int) -> tuple[int, int, str]:
    """Messages, a thousand on each socket, one at a time: each has one answer."""
    failed, refused, slowest = 0, 0, 0.0
    for first in track(range(0, count, 1000), "messages"):
        with opened(running) as page:
            for number in range(first, min(first + 1000, count)):
                text = random_messages.message(rng, number)
                if rng.random() < 0.05:
                    text = f'{{"id": {ids(rng)}, "kind": "impact", "state": {{}}}}'
                started = time.monotonic()
                try:
                    page.send(text)
                    answer = json.loads(page.recv(timeout=PATIENCE), parse_constant=_refuse)
                    failed += BUG in answer.get("error", "")
                    refused += not answer["ok"]
                except (TimeoutError, ConnectionClosed, ValueError, KeyError) as error:
                    print(f"message {number}: {error!r}: {text[:300]}", file=sys.stderr)
                    failed += 1
                    break
                slowest = max(slowest, time.monotonic() - started)
        failed += not works(running)
    return count, failed, f"{refused:,} refused in one line; slowest answer {slowest:.1f} s"


def _refuse(name: str) -> Any:
    raise ValueError(name)


def names(running: launch.Running, rng: random.Random) -> tuple[int, int, str]:
    """Headers `Host` made of parts of good and bad ones; good ones are addresses and localhost alone."""
    good = ["127.0.0.1", "localhost", "[::1]", "10.1.2.3"]
    bad = ["evil.com", "localhost.evil.com", "127.0.0.1.nip.io", "evil.com@127.0.0.1", "127.0.0.1@evil.com", "a b",
           "127.0.0.1/evil", "127.0.0.1?x", "127.0.0.1#x", "[", "0x7f.1", "127.1", "", "localhost%00"]  # fmt: skip
    tried = [(address + rng.choice(("", f":{running.port}")), address in good) for address in [*good, *bad] * 4]
    failed = 0
    for host, allowed in tried:
        status = get(running, f"/?token={running.access.token}", host=host).status
        failed += (status == 200) != allowed
    return len(tried), failed + (not works(running)), "addresses and localhost alone are served"


def _is_open(running: launch.Running, **options: Any) -> bool:
    try:
        with opened(running, **options):
            return True
    except (InvalidStatus, ConnectionClosed, OSError):
        return False


def origins(running: launch.Running, rng: random.Random) -> tuple[int, int, str]:
    """Pages of other sites open no socket."""
    here = f"http://127.0.0.1:{running.port}"
    local = f"127.0.0.1:{running.port}"
    bad = [None, "null", "file://", "http://evil.com", "http://127.0.0.1", f"http://localhost:{running.port}"]
    bad += [f"ftp://{local}", f"{here}@evil.com", f"http://evil.com@{local}", "http://[", "x" * 3000]
    bad += [f"http://127.0.0.1:{port}" for port in rng.sample(range(1024, 60_000), 20) if port != running.port]
    failed = sum(_is_open(running, origin=origin) for origin in bad) + (not _is_open(running, origin=here))
    return len(bad) + 1, failed, "sockets of this page alone"


def tokens(running: launch.Running, rng: random.Random) -> tuple[int, int, str]:
    """Wrong tokens, two of them, and changed ones open no page and no socket."""
    right = running.access.token
    bad = [
        "",
        "a",
        right[:-1],
        right + "x",
        right.swapcase(),
        f"a&token={right}",
        f"{right}&token=a",
        f"{right}&token={right}",
    ]
    for _ in range(30):
        place = rng.randrange(len(right))
        bad.append(right[:place] + rng.choice(string.ascii_letters.replace(right[place], "")) + right[place + 1 :])
    failed = sum(get(running, f"/?token={token}").status != 403 for token in bad)
    failed += sum(_is_open(running, address=f"ws://127.0.0.1:{running.port}/ws?token={token}") for token in bad)
    return 2 * len(bad), failed + (not works(running)), "refused"


def paths(running: launch.Running, rng: random.Random) -> tuple[int, int, str]:
    """Paths to other files are not found."""
    parts = [
        "..",
        "%2e%2e",
        "..%2f",
        "static",
        "server.py",
        "etc",
        "passwd",
        "",
        "page",
        "%00",
        "\\",
        "__init__.py",
        "ws",
        "~",
    ]
    tried = ["/static/" + "/".join(rng.choices(parts, k=rng.randrange(1, 6))) for _ in range(200)]
    results = [get(running, path.replace("\\", "%5c")) for path in tried]
    failed = sum(answer.status not in (404, 403, 400, 307) or b"import" in answer.content for answer in results)  # pyright: ignore
    return len(tried), failed, "not found"


def bombs(running: launch.Running) -> tuple[int, int, str]:
    """Messages and files that are large, deep, or slow to read."""
    tables = "".join(f"[a{n}]\n" for n in range(100_000))
    texts = {
        "tables": tables, "tables within the limit": tables[:65_000], "deep": "a = " + "[" * 60_000,
        "keys": "\n".join(f"a{n} = 1" for n in range(7_000)), "dotted": ".".join("a" * 30_000) + " = 1",
        "one line": "1," * 450_000, "blanks": " " * 900_000, "no ends": "t,E\ns,MPa\n" + "1,1\n" * 200_000,
    }  # fmt: skip
    slowest, failed = 0.0, 0
    for words, text in texts.items():
        name = "a.csv" if words in ("one line", "blanks", "no ends") else "a.toml"
        content = [{"name": name, "data": base64.b64encode(text.encode()).decode()}]
        started = time.monotonic()
        with opened(running) as page:
            page.send(json.dumps({"id": 1, "kind": "file", "files": content}))
            answer = json.loads(page.recv(timeout=PATIENCE))
        took = time.monotonic() - started
        print(f"bomb {words}: {took:.2f} s, {answer.get('error', answer.get('words'))[:120]}", file=sys.stderr)
        slowest, failed = max(slowest, took), failed + (BUG in answer.get("error", ""))
    for text in (
        "[" * 60_000,
        '{"a":' * 10_000,
        "9" * 60_000,
        "x" * 9_000_000,
        json.dumps({"kind": "impact", "a": "x" * 70_000}),
    ):
        with suppress(ConnectionClosed), opened(running) as page:
            page.send(text)
            page.recv(timeout=PATIENCE)
    return len(texts) + 5, failed + (not works(running)), f"slowest file {slowest:.1f} s"


def half_open(running: launch.Running, count: int = 100) -> tuple[int, int, str]:
    """Requests that are not finished hold nobody else up."""
    held = [socket.create_connection(("127.0.0.1", running.port)) for _ in range(count)]
    for connection in held:
        connection.sendall(b"GET / HTTP/1.1\r\nHost: 127.0")
    started = time.monotonic()
    failed = not works(running)
    took = time.monotonic() - started
    for connection in held:
        connection.close()
    return count, int(failed), f"another page is answered in {took:.2f} s"


def crowd(running: launch.Running) -> tuple[int, int, str]:
    """More pages than are served at a time: the others are refused, and places become free."""
    done, ready, accepted = threading.Event(), threading.Semaphore(0), []

    def hold() -> None:
        try:
            with opened(running):
                accepted.append(True)
                ready.release()
                done.wait(PATIENCE)
        except (InvalidStatus, ConnectionClosed, OSError, TimeoutError):
            ready.release()

    tried = MOST_SOCKETS + 20
    holders = [threading.Thread(target=hold) for _ in range(tried)]
    for thread in holders:
        thread.start()
    for _ in holders:
        ready.acquire(timeout=PATIENCE)
    count = len(accepted)
    done.set()
    for thread in holders:
        thread.join()
    time.sleep(1.0)
    return tried, int(count > MOST_SOCKETS) + (not works(running)), f"{count} served, {tried - count} refused"


if __name__ == "__main__":
    main()
