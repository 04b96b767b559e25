"""The operator's page in a real Chromium, at `rfnav view` beside `rfnav run`, each a process, and a
robot in the flat-land apartment: a goal typed there is found, a zone drawn there is kept out of,
the space bar stops."""

import math
import os
import re
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

import pytest
from chromium import chromium, needs_chromium, page_at, until
from labelled_robot import LabelledRobot
from places import ROOT

from hil_sim.driving.link import free_port
from runtime.core.mapping.zones import Zone
from runtime.robot.session import BusConfig

pytestmark = list(needs_chromium)
SETTINGS = (
    'research.detector_source="topic"', 'research.detector_labels=["chair"]', "panel.experts=[]",
    "control.look_radps=1.0", "safety.plan_stale_s=5.0", "safety.odom_stale_s=2.0",
    "safety.frame_stale_s=4.0", "safety.depth_stale_s=2.0",
)  # fmt: skip
RADIUS_M, HALTS_WITHIN_M = 0.18, 0.3
RUG = (2.1, 3.2), (2.8, 4.2)  # two corners, across the straight way to the chair
NEAR_PX, FAR_PX = (480.0, 320.0), (680.0, 620.0)  # two points of the page over the map


@contextmanager
def child(folder: Path, *words: str) -> Iterator[subprocess.Popen[bytes]]:
    """`rfnav` with those words; what it says is in a file of the folder."""
    env = os.environ | {"XDG_STATE_HOME": str(folder)}
    with (folder / f"{words[0]}.log").open("wb") as log:
        command = [sys.executable, "-m", "runtime", *words]
        process = subprocess.Popen(command, stdout=log, stderr=log, cwd=ROOT, env=env)
    try:
        yield process
    finally:
        process.terminate()
        process.wait(30)


@pytest.fixture
def there(tmp_path: Path) -> Iterator[tuple[LabelledRobot, str]]:
    """A robot that is driven, and the address of the page."""
    endpoint, port = f"tcp/127.0.0.1:{free_port()}", free_port()
    robot = LabelledRobot(BusConfig(listen=(endpoint,)))
    bus = "--set", f"bus.connect=['{endpoint}']", "--set", "bus.listen=[]"
    given = [part for setting in SETTINGS for part in ("--set", setting)]
    with (
        child(tmp_path, "run", *bus, *given),
        child(tmp_path, "view", "--listen", f"127.0.0.1:{port}", *bus),
    ):
        robot.start()
        try:
            robot.until(lambda: robot.states and robot.state()["runtime"]["state"] == "ready", 60.0)
            yield robot, f"http://127.0.0.1:{port}/"
        finally:
            robot.close()


@pytest.fixture
def recording(tmp_path: Path) -> Iterator[str]:
    """The address of a page on a drive of before."""
    port = free_port()
    file = str(ROOT / "tests/refs/realtime.mcap")
    with child(tmp_path, "view", "--listen", f"127.0.0.1:{port}", "--replay", file):
        until_s = time.monotonic() + 60.0
        while time.monotonic() < until_s:
            with suppress(OSError), socket.create_connection(("127.0.0.1", port), 1.0):
                break
            time.sleep(0.2)
        yield f"http://127.0.0.1:{port}/"


class Track:
    """Where the robot has been, as it was, in a thread of its own."""

    def __init__(self, robot: LabelledRobot) -> None:
        self._robot, self._ending = robot, threading.Event()
        self.been = [self.now]
        self._thread = threading.Thread(target=self._follow)

    @property
    def now(self) -> tuple[float, float]:
        return self._robot.home.pose.x_m, self._robot.home.pose.y_m

    def __enter__(self) -> "Track":
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._ending.set()
        self._thread.join()

    def _follow(self) -> None:
        while not self._ending.wait(0.05):
            self.been.append(self.now)


def draw_box(page: Any, corner: tuple[float, float], other: tuple[float, float]) -> None:
    """Drag from one point of the map, m, to the other."""
    (x0, y0), (x1, y1) = (pointed(page, *px) for px in (NEAR_PX, FAR_PX))

    def at(xy: tuple[float, float]) -> tuple[float, float]:
        right = (xy[0] - x0) / (x1 - x0), (xy[1] - y0) / (y1 - y0)
        return tuple(
            n + share * (f - n) for n, f, share in zip(NEAR_PX, FAR_PX, right, strict=True)
        )

    page.mouse.move(*at(corner))
    page.mouse.down()
    page.mouse.move(*at(other), steps=6)
    page.mouse.up()


def pointed(page: Any, *px: float) -> tuple[float, float]:
    """What the map tells, m, of a point of the page."""
    page.mouse.move(*px)
    x, y = re.findall(r"-?\d+\.\d+", page.locator("#pointed").inner_text())
    return float(x), float(y)


def known_m2(page: Any) -> int:
    told = re.search(r"(\d+) square", page.get_attribute("#map", "aria-label"))
    return int(told[1]) if told else 0


def moves(robot: LabelledRobot) -> bool:
    return robot.twist.v_mps > 0.05


def test_the_same_page_plays_a_recording(recording):
    with chromium() as browser, page_at(browser, recording) as page:
        page.set_default_timeout(30_000)
        page.wait_for_selector('body[data-mode="replay"]')
        page.wait_for_selector("#play")
        assert page.locator("#stop").is_hidden()
        page.click("#play")
        until(page, lambda: known_m2(page) > 0, 30)
        page.click("#play >> text=Halt")
        page.focus("#scrub")
        page.keyboard.press("End")
        page.wait_for_selector("#why-body >> text=Decision 8, for “toilet”")
        page.wait_for_selector("#now-does >> text=Found.")
        ended_m2 = known_m2(page)
        page.fill("#scrub", "60")  # tenths of a second
        page.wait_for_selector("#scrub-told >> text=6 s of 31 s")
        until(page, lambda: known_m2(page) < ended_m2)


def test_a_goal_typed_is_found_round_a_zone_drawn_and_the_space_bar_stops(there):
    robot, url = there
    with chromium() as browser, page_at(browser, url) as page, Track(robot) as track:
        page.set_default_timeout(60_000)
        page.wait_for_selector('body[data-link="ok"]')
        page.click("[data-tool=zone]")
        draw_box(page, *RUG)
        page.get_by_role("button", name="Keep", exact=True).click()
        page.wait_for_selector("#zones-list >> text=zone 1", state="attached")

        page.fill("#goal-text", "chair")
        page.press("#goal-text", "Enter")
        until(page, lambda: known_m2(page) > 0, 60)
        first_m2 = known_m2(page)
        until(page, lambda: moves(robot), 60)

        page.keyboard.press("Space")
        before = track.now
        page.wait_for_selector("#notice >> text=It stays so until it is released.")
        until(page, lambda: robot.twist.v_mps == robot.twist.w_radps == 0.0)
        assert math.dist(before, track.now) < HALTS_WITHIN_M
        held = track.now
        page.wait_for_timeout(1500)
        assert track.now == held

        page.click('#stop[data-state="stopped"]')
        page.click("#release-yes")
        page.wait_for_selector("#notice >> text=Found.")
        assert known_m2(page) > first_m2
        x, y, _ = robot.home.things["chair"]
        assert math.dist(track.now, (x, y)) < 1.5
        assert "chair" in page.locator("#things-list li").first.text_content()
    (x0, y0), (x1, y1) = RUG
    zone = Zone("", ((x0, y0), (x1, y0), (x1, y1), (x0, y1)))
    assert min(zone.outside_m(xy) for xy in track.been) > RADIUS_M - 0.03
