"""A live feed, a service on a real bus, an audience, a certificate, a page's server whose feed a
test holds, and a page in a browser, for the tests beside it."""

import subprocess
from collections.abc import Iterator
from functools import partial
from pathlib import Path

import page_home as home
import pytest
from chromium import chromium, page_at
from live_page import Dozing, at_port
from page_audience import PageAudience
from page_double import PageDouble, serving
from page_server import HeldFeed, allowed, free_port, page_server
from page_service import PageService

from runtime.commands.running import running
from runtime.tracing.budgets import read_budgets
from runtime.view import live
from runtime.view.live import LiveFeed, LiveParts


@pytest.fixture(scope="session")
def pair(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    folder = tmp_path_factory.mktemp("pair")
    certificate, key = folder / "certificate.pem", folder / "key.pem"
    subprocess.run(
        ["openssl", "req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:prime256v1",
         "-nodes", "-days", "2", "-subj", "/CN=robot", "-keyout", key, "-out", certificate],
        check=True, capture_output=True,
    )  # fmt: skip
    key.chmod(0o600)
    return certificate, key


@pytest.fixture
def page(tmp_path: Path) -> Path:
    """The folder of a page."""
    (tmp_path / "index.html").write_text("<!doctype html><title>RF-NAV</title>")
    (tmp_path / "page.js").write_text("export {};")
    return tmp_path


@pytest.fixture
def feed() -> HeldFeed:
    return HeldFeed()


@pytest.fixture
def port(feed: HeldFeed, page: Path) -> Iterator[int]:
    """Of a server of that page."""
    port = free_port()
    with page_server(allowed(port), feed, page):
        yield port
    assert feed.closed


@pytest.fixture
def bus_port() -> int:
    return free_port()


@pytest.fixture
def service(bus_port: int) -> Iterator[PageService]:
    service = PageService(bus_port)
    yield service
    service.close()


@pytest.fixture
def audience() -> PageAudience:
    return PageAudience()


@pytest.fixture
def dozing() -> Dozing:
    return Dozing()


@pytest.fixture
def live_feed(
    bus_port: int, audience: PageAudience, dozing: Dozing, monkeypatch: pytest.MonkeyPatch
) -> Iterator[LiveFeed]:
    monkeypatch.setattr(live, "LINGER_S", 0.2)
    monkeypatch.setattr(live, "RETRY_S", 0.2)
    config = at_port(bus_port)
    connect = partial(running, config.bus)
    feed = LiveFeed(LiveParts(connect, config, read_budgets(), lambda status: ["a line"]))
    feed._changed = dozing
    feed.start(audience)
    yield feed
    feed.close()


@pytest.fixture(scope="module")
def browser() -> Iterator[object]:
    with chromium() as opened:
        yield opened


@pytest.fixture
def told(browser) -> Iterator[tuple[PageDouble, object]]:
    """A server, and a page at it that was told all of a search."""
    with serving() as double, page_at(browser, double.url) as page:
        home.tell_all(double)
        page.wait_for_selector("#now[data-any]")
        page.wait_for_selector("#map-empty", state="hidden")
        yield double, page
