"""Make the picture of the explorer in README and documentation: `.venv/bin/python docs/make_explorer_picture.py`.

It needs Chromium, and playwright of the development tools.
"""

import io
import shutil
from pathlib import Path
from urllib.parse import urlencode

from PIL import Image
from playwright.sync_api import sync_playwright

from restitution.explorer import launch

PICTURE = Path(__file__).parent / "_static" / "explorer.png"
STATE = {"page.tab": "impact", "page.pins": "page.tab=impact&material.viscosity=1000"}
OPTIONS = ["--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-background-networking"]


def main() -> None:
    """Open the page with one pinned setting and save what it shows."""
    running = launch.listen(port=0)
    launch.warm_up()
    launch.in_thread(running)
    with sync_playwright() as driver:
        browser = driver.chromium.launch(executable_path=shutil.which("chromium"), args=OPTIONS)
        window = {"width": 1680, "height": 1195}
        page = browser.new_context(reduced_motion="reduce", color_scheme="light", viewport=window).new_page()
        page.goto(f"{running.address}#{urlencode(STATE)}")
        page.wait_for_selector("#compare tbody tr:nth-child(2)", state="attached")
        page.wait_for_timeout(3000)
        taken = page.screenshot()
        browser.close()
    running.stop()
    with Image.open(io.BytesIO(taken)) as picture:
        picture.convert("RGB").quantize(256).save(PICTURE, optimize=True)


if __name__ == "__main__":
    main()
