#!/usr/bin/env python3
"""Takes pictures of the operator's page while a simulated robot searches: on a desk and on a
telephone, searching, held, stopped, found.

  scripts/screenshots.py --out docs/figures
"""

import argparse
import io
import os
import shutil
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any

from PIL import Image
from playwright.sync_api import Browser, Error, Page, sync_playwright

ROOT = Path(__file__).resolve().parent.parent
READY_S, SEARCH_S, QUIET_S = 600.0, 1200.0, 60.0
EVERY_MS, SETTLED_MS = 200, 1200
COLOURS, MOST_BYTES = 256, 250_000
KNOWN_M2, DRIVEN_M = 12, 1.5  # of a search that there is something to see of
# A machine that renders, thinks and draws pictures at once is late; a robot that is held for that
# shows nothing.
PATIENT = "safety.depth_stale_s=2.0", "safety.frame_stale_s=4.0", "safety.plan_stale_s=6.0"
DEVICES: dict[str, dict[str, Any]] = {
    "desk": {"viewport": {"width": 1440, "height": 900}, "color_scheme": "light"},
    "telephone": {
        "viewport": {"width": 390, "height": 844},
        "color_scheme": "dark",
        "device_scale_factor": 2,
        "is_mobile": True,
        "has_touch": True,
    },
}


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, default=ROOT / "docs/figures")
    parser.add_argument("--goal", default="toilet")
    parser.add_argument("--scene", default="maple")
    parser.add_argument("--start", default="0")
    given = parser.parse_args()
    chromium = shutil.which("chromium")
    if not chromium:
        print("screenshots: no Chromium: scripts/setup --all installs it", file=sys.stderr)
        return 2
    given.out.mkdir(parents=True, exist_ok=True)
    with ExitStack() as stack:
        bus = f"tcp/127.0.0.1:{_free_port()}"
        settings = [part for setting in PATIENT for part in ("--set", setting)]
        where = "--listen", bus, "--scene", given.scene, "--start", given.start
        robot = stack.enter_context(_child("hil_sim", "demo", "--serve", *where, *settings))
        port = _free_port()
        to = "--set", f'bus.connect=["{bus}"]', "--set", "bus.listen=[]"
        stack.enter_context(_child("runtime", "view", "--listen", f"127.0.0.1:{port}", *to))
        browser = stack.enter_context(sync_playwright()).chromium.launch(executable_path=chromium)
        stack.callback(browser.close)
        pages = _pages(browser, f"http://127.0.0.1:{port}/")
        _take(pages, robot, given.goal, given.out)
    return 0


def _take(pages: dict[str, Page], robot: subprocess.Popen[bytes], goal: str, out: Path) -> None:
    """One search, and what is to be seen of it."""
    desk = pages["desk"]
    desk.fill("#goal-text", goal)
    desk.press("#goal-text", "Enter")
    _until(desk, lambda: _known_m2(desk) >= KNOWN_M2 and _driven_m(desk) >= DRIVEN_M, SEARCH_S)
    _until(desk, lambda: desk.is_hidden("#notice"), QUIET_S, "a busy machine: it sheds work")
    _shoot(pages, out, "searching")
    camera = _camera_of(robot)
    os.kill(camera, signal.SIGSTOP)
    try:
        _until(desk, lambda: "Held." in desk.inner_text("#notice"), READY_S)
        desk.wait_for_timeout(SETTLED_MS)
        _shoot(pages, out, "held")
    finally:
        os.kill(camera, signal.SIGCONT)
    _until(desk, lambda: "Held." not in desk.inner_text("#notice"), READY_S)
    desk.keyboard.press("Space")
    _until(desk, lambda: "Stopped." in desk.inner_text("#notice"), READY_S)
    _shoot(pages, out, "stopped")
    desk.click('#stop[data-state="stopped"]')
    desk.click("#release-yes")
    _until(desk, lambda: "Found." in desk.inner_text("#notice"), SEARCH_S)
    _shoot(pages, out, "found")


def _camera_of(robot: subprocess.Popen[bytes]) -> int:
    """The process that renders what a simulated robot sees."""
    children = Path(f"/proc/{robot.pid}/task/{robot.pid}/children").read_text().split()
    return next(
        int(child)
        for child in children
        if b"spawn_main" in Path(f"/proc/{child}/cmdline").read_bytes()
    )


def _pages(browser: Browser, url: str) -> dict[str, Page]:
    """Of a service that takes goals."""
    pages = {}
    by_s = time.monotonic() + READY_S
    for device, how in DEVICES.items():
        page = pages[device] = browser.new_context(**how).new_page()
        while True:
            try:
                page.goto(url)
                break
            except Error as error:  # it is not up yet
                if time.monotonic() > by_s:
                    raise
                print(f"waiting: {error.message}", file=sys.stderr)
                time.sleep(2.0)
        _until(page, lambda page=page: "Ready" in page.inner_text("#now-goal"), READY_S)
    return pages


def _shoot(pages: dict[str, Page], out: Path, what: str) -> None:
    for device, page in pages.items():
        page.evaluate("document.getElementById('toasts').replaceChildren()")
        page.wait_for_timeout(300)
        path = out / f"view-{device}-{what}.png"
        for colours in (COLOURS, COLOURS // 2, COLOURS // 4):
            image = Image.open(io.BytesIO(page.screenshot())).convert("RGB")
            image.quantize(colours).save(path, optimize=True)
            if path.stat().st_size <= MOST_BYTES:
                break
        print(f"{path}: {path.stat().st_size // 1000} KB")


def _known_m2(page: Page) -> float:
    words = (page.get_attribute("#map", "aria-label") or "").split()
    return next((float(word) for word in words if word.isdigit()), 0.0)


def _driven_m(page: Page) -> float:
    told = page.locator("#now-figures div", has_text="way").locator("dd")
    return float(told.first.inner_text().split()[0]) if told.count() else 0.0


def _until(page: Page, true: Callable[[], object], within_s: float, instead: str = "") -> None:
    """The page lives on meanwhile. What does not come to be ends all, unless something is said
    instead."""
    by_s = time.monotonic() + within_s
    while not true():
        if time.monotonic() > by_s and instead:
            print(f"screenshots: {instead}", file=sys.stderr)
            return
        if time.monotonic() > by_s:
            raise SystemExit(f"screenshots: not in {within_s:.0f} s: {page.inner_text('#now')}")
        page.wait_for_timeout(EVERY_MS)


@contextmanager
def _child(module: str, *words: str) -> Iterator[subprocess.Popen[bytes]]:
    command = [sys.executable, "-m", module, *words]
    process = subprocess.Popen(command, cwd=ROOT, env={**os.environ, "PYTHONPATH": str(ROOT)})
    try:
        yield process
    finally:
        process.send_signal(signal.SIGINT)
        try:
            process.wait(60)
        except subprocess.TimeoutExpired:
            process.kill()


def _free_port() -> int:
    with socket.socket() as listener:
        listener.bind(("127.0.0.1", 0))
        return int(listener.getsockname()[1])


if __name__ == "__main__":
    sys.exit(main())
