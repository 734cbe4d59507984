"""Time from a key press to the redrawn curve in the explorer: `python benchmarks/explorer.py`.

It needs Chromium and `pip install playwright 'restitution[web]'`, and writes `tables/explorer.md`. The browser
measures: the time starts with the time stamp of the key press and ends when the picture of F(t) has its new nodes,
and in the last column when the browser has painted the frame with them.

Several pages at once are sockets that ask as the page does, 60 times a second, and read no more of an answer than its
number; they share one process, whose time is printed. The time is that from an input to its answer; an input that a
newer one replaces, before its turn comes, has none.
"""

from __future__ import annotations

import asyncio
import json
import multiprocessing
import os
import re
import shutil
import subprocess
import sys
import time
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from contextlib import contextmanager
from itertools import count
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

import numpy as np
from machine import describe
from playwright.sync_api import sync_playwright
from websockets.asyncio.client import connect

TABLE = Path(__file__).parent / "tables" / "explorer.md"
PRESSES = 200
PAUSE = 40
SLIDERS = {
    "impact.velocity": "impact velocity",
    "material.viscosity": "viscosity",
    "material.poisson_ratio": "Poisson ratio",
}
START = {"impact.velocity": 0.3, "material.viscosity": 3e3}
TICK, SECONDS = 1.0 / 60.0, 8.0
NUMBER = re.compile(r'"id": (\d+), "kind": "(\w+)"')
OPTIONS = ["--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-background-networking"]
HOOK = """() => {
  const figure = explorer.tabs.impact.force.figure;
  const redraw = figure.redraw.bind(figure);
  let pressed = null, before = null;
  window.times = [];
  window.frames = [];
  const painted = (start) => {
    const { port1, port2 } = new MessageChannel();
    port1.onmessage = () => frames.push(performance.now() - start);
    port2.postMessage(null);
  };
  addEventListener("keydown", (event) => { pressed = event.timeStamp; before = explorer.last.impact; }, true);
  figure.redraw = () => {
    redraw();
    if (pressed === null || explorer.last.impact === before) return;
    const start = pressed;
    pressed = null;
    times.push(performance.now() - start);
    // A message comes after the frame in which it was sent.
    requestAnimationFrame(() => painted(start));
  };
}"""


@contextmanager
def server() -> Iterator[str]:
    """Start a server; yields its address."""
    command = [sys.executable, "-m", "restitution", "explore", "--no-browser", "--port", "0"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        yield next(word for line in process.stdout for word in line.split() if word.startswith("http"))
        process.terminate()


async def drag(address: str, key: str, place: float, seconds: float, spent: dict[str, list[float]]) -> None:
    """Move a slider for some seconds."""
    url, numbers = urlsplit(address), count()
    sent: dict[int, tuple[float, float]] = {}
    target, origin = f"ws://{url.netloc}/ws?{url.query}", f"http://{url.netloc}"
    async with connect(target, origin=origin, compression=None, max_size=None) as socket:  # pyright: ignore

        async def ask(kind: str, moved: float, value: float) -> None:
            number = next(numbers)
            sent[number] = moved, value
            await socket.send(json.dumps({"id": number, "kind": kind, "state": {key: value}}))

        async def receive() -> None:
            await socket.recv()
            async for text in socket:
                answer = NUMBER.match(str(text[1:60]))
                assert answer is not None
                moved, value = sent.pop(int(answer[1]))
                spent[answer[2]].append(time.perf_counter() - moved)
                if answer[2] == "impact" and key != "impact.velocity":
                    await ask("velocity", moved, value)

        receiver = asyncio.create_task(receive())
        start = time.perf_counter() + place * TICK
        for n in range(round(seconds / TICK)):
            await asyncio.sleep(start + n * TICK - time.perf_counter())
            await ask("impact", start + n * TICK, START[key] * (1.0 + 1e-3 * ((7 * n + round(1e3 * place)) % 997)))
        await asyncio.sleep(0.5)
        receiver.cancel()


def pages(address: str, key: str, number: int, seconds: float = SECONDS) -> tuple[dict[str, list[float]], float]:
    """Return the times from input to answer [s] of pages that all move a slider, and the processor time of these."""
    results: dict[str, list[float]] = {"impact": [], "velocity": []}

    async def all_of_them() -> None:
        await asyncio.gather(*(drag(address, key, n / number, seconds, results) for n in range(number)))

    before = time.process_time()
    asyncio.run(all_of_them())
    return results, time.process_time() - before


def quantiles(times: Any) -> str:
    """Median, 95 % and longest of some times [ms] as cells of a table."""
    median, high, longest = np.quantile(times, [0.5, 0.95, 1.0])
    return f"{median:.1f} ms | {high:.1f} ms | {longest:.1f} ms |"


def in_browser(page: Any, key: str) -> tuple[Any, Any]:
    """Press keys on a slider; return the times [ms] until the curve is drawn, and until it is painted."""
    page.locator(f"[data-key='{key}'] input[type=range]").focus()
    page.evaluate("times.length = frames.length = 0")
    for n in range(PRESSES):
        page.keyboard.press("ArrowLeft" if n % 50 < 25 else "ArrowRight")
        page.wait_for_timeout(PAUSE)
    page.wait_for_timeout(500)
    return page.evaluate("times"), page.evaluate("frames")


def main() -> None:
    """Press keys, print the times and write the table."""
    rows = [
        "| one page in the browser | median | 95 % | longest | median with the frame |",
        "|---|---:|---:|---:|---:|",
    ]
    more = [
        "| pages | slider | answers per second and page | median | 95 % | longest |",
        "|---:|---|---:|---:|---:|---:|",
    ]
    spawned = ProcessPoolExecutor(1, multiprocessing.get_context("spawn"))
    with server() as address, sync_playwright() as driver, spawned as others:
        browser = driver.chromium.launch(executable_path=shutil.which("chromium"), args=OPTIONS)
        page = browser.new_context(reduced_motion="reduce", viewport={"width": 1280, "height": 1400}).new_page()
        page.goto(address)
        page.wait_for_selector("[data-output=restitution_coefficient][data-value]:visible")
        page.wait_for_timeout(15_000)
        page.evaluate(HOOK)

        def row(words: str, key: str) -> None:
            drawn, painted = in_browser(page, key)
            rows.append(f"| {words} | {quantiles(drawn)} {np.median(painted):.1f} ms |")
            print(rows[-1], flush=True)

        for key, words in SLIDERS.items():
            row(words, key)
        page.locator("button.play").first.click()
        row("impact velocity, the slow motion plays", "impact.velocity")
        row("viscosity, the slow motion plays", "material.viscosity")
        page.locator("button.play").first.click()
        working = others.submit(pages, address, "impact.velocity", 7, 22.0)
        row("impact velocity, seven further pages move theirs", "impact.velocity")
        working.result()
        version = browser.version
        browser.close()
        for number in (1, 8):
            for key in START:
                result, used = others.submit(pages, address, key, number).result()
                rate = len(result["impact"]) / SECONDS / number
                more.append(
                    f"| {number} | {SLIDERS[key]} | {rate:.0f} | {quantiles(1e3 * np.array(result['impact']))}"
                )
                print(more[-1], f"their own time {used / SECONDS:.2f} of a core", flush=True)
    load = os.getloadavg()[0]
    about = f"{describe().lines()[0]}, Chromium {version} without a graphics card; load of the machine {load:.1f}."
    TABLE.write_text("\n".join(["", *rows, "", *more, "", about, ""]), encoding="utf-8")


if __name__ == "__main__":
    main()
