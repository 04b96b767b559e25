"""A live feed, a service on a real bus and an audience, for the tests beside it."""

from collections.abc import Iterator
from functools import partial

import pytest
from live_page import Dozing, at_port
from page_audience import PageAudience
from page_server import free_port
from page_service import PageService

from runtime.commands.running import running
from runtime.tracing.budgets import read_budgets
from runtime.view import live
from runtime.view.live import LiveFeed, LiveParts


@pytest.fixture
def port() -> int:
    return free_port()


@pytest.fixture
def service(port: int) -> Iterator[PageService]:
    service = PageService(port)
    yield service
    service.close()


@pytest.fixture
def audience() -> PageAudience:
    return PageAudience()


@pytest.fixture
def dozing() -> Dozing:
    return Dozing()


@pytest.fixture
def feed(
    port: int, audience: PageAudience, dozing: Dozing, monkeypatch: pytest.MonkeyPatch
) -> Iterator[LiveFeed]:
    monkeypatch.setattr(live, "LINGER_S", 0.2)
    monkeypatch.setattr(live, "RETRY_S", 0.2)
    config = at_port(port)
    connect = partial(running, config.bus)
    feed = LiveFeed(LiveParts(connect, config, read_budgets(), lambda status: ["a line"]))
    feed._changed = dozing
    feed.start(audience)
    yield feed
    feed.close()
