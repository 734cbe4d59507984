"""Time from a key press to the redrawn curve in the explorer: `python benchmarks/explorer.py`.

It needs Chromium and `pip install playwright 'restitution[web]'`, and writes `tables/explorer.md`. The browser
measures: the time starts with the time stamp of the key press and ends when the canvas of F(t) is drawn anew.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
from machine import describe
from playwright.sync_api import sync_playwright

TABLE = Path(__file__).parent / "tables" / "explorer.md"
PRESSES = 200
PAUSE = 40
SLIDERS = {
    "impact.velocity": "impact velocity",
    "material.viscosity": "viscosity",
    "material.poisson_ratio": "Poisson ratio",
}
OPTIONS = ["--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-background-networking"]
HOOK = """() => {
  const figure = explorer.tabs.impact.force.figure;
  const paint = figure.paint.bind(figure);
  let pressed = null, before = null;
  window.times = [];
  addEventListener("keydown", (event) => { pressed = event.timeStamp; before = explorer.last.impact; }, true);
  figure.paint = () => {
    const done = paint();
    if (pressed !== null && explorer.last.impact !== before) {
      times.push(performance.now() - pressed);
      pressed = null;
    }
    return done;
  };
}"""


def main() -> None:
    """Press keys, print the times and write the table."""
    command = [sys.executable, "-m", "restitution", "explore", "--no-browser", "--port", "0"]
    server = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
    assert server.stdout is not None
    address = next(word for line in server.stdout for word in line.split() if word.startswith("http"))
    rows = ["| slider | median | 95 % | longest |", "|---|---:|---:|---:|"]
    with sync_playwright() as driver:
        browser = driver.chromium.launch(executable_path=shutil.which("chromium"), args=OPTIONS)
        page = browser.new_context(reduced_motion="reduce", viewport={"width": 1280, "height": 1400}).new_page()
        page.goto(address)
        page.wait_for_selector("[data-output=restitution_coefficient][data-value]:visible")
        page.wait_for_timeout(2000)
        page.evaluate(HOOK)
        for key, words in SLIDERS.items():
            slider = page.locator(f"[data-key='{key}'] input[type=range]")
            slider.focus()
            page.evaluate("times.length = 0")
            for n in range(PRESSES):
                page.keyboard.press("ArrowLeft" if n % 50 < 25 else "ArrowRight")
                page.wait_for_timeout(PAUSE)
            page.wait_for_timeout(500)
            times = np.array(page.evaluate("times"))
            median, high = np.quantile(times, [0.5, 0.95])
            rows.append(f"| {words} | {median:.1f} ms | {high:.1f} ms | {times.max():.1f} ms |")
            print(
                f"{words}: {times.size} of {PRESSES} presses, median {median:.1f} ms, 95 % {high:.1f} ms", flush=True
            )
        version = browser.version
        browser.close()
    server.terminate()
    load = os.getloadavg()[0]
    about = f"{describe().lines()[0]}, Chromium {version} without a graphics card; load of the machine {load:.1f}."
    TABLE.write_text("\n".join(["", *rows, "", about, ""]), encoding="utf-8")


if __name__ == "__main__":
    main()
