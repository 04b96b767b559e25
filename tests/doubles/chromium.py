"""Debian's Chromium, headless, and pages in it that keep what they complain of."""

import shutil
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from importlib.util import find_spec
from typing import TYPE_CHECKING, Any

import pytest

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Page

CHROMIUM = shutil.which("chromium") or ""
DESK, TELEPHONE = {"width": 1440, "height": 900}, {"width": 390, "height": 844}
needs_chromium = (
    pytest.mark.skipif(
        not CHROMIUM or find_spec("playwright") is None,
        reason="THE PAGE IS NOT TESTED: no Chromium (scripts/setup --all) or no playwright",
    ),
    pytest.mark.slow,  # a browser is some processes
)
"""The marks of a file whose tests need it."""
WITHIN_S, EVERY_MS = 15.0, 50


@contextmanager
def chromium() -> "Iterator[Browser]":
    from playwright.sync_api import sync_playwright

    with sync_playwright() as play:
        browser = play.chromium.launch(executable_path=CHROMIUM)
        try:
            yield browser
        finally:
            browser.close()


@contextmanager
def page_at(
    browser: "Browser", url: str, telephone: bool = False, but: str = "\n", **more: Any
) -> "Iterator[Page]":
    """A page at that address; what its console complains of, without `but` in it, or what it threw,
    fails the test. `more`: of Playwright's `new_context`."""
    if telephone:
        more = {"has_touch": True, "is_mobile": True, "device_scale_factor": 2, **more}
    more = {"viewport": TELEPHONE if telephone else DESK, **more}
    context = browser.new_context(**more)
    page, complaints = context.new_page(), list[str]()
    page.on("console", lambda m: complaints.append(m.text) if m.type in ("error", "warning") else 0)
    page.on("pageerror", lambda error: complaints.append(f"{error.message}\n{error.stack}"))
    page.set_default_timeout(15_000)
    try:
        page.goto(url)
        yield page
    finally:
        context.close()
    assert [line for line in complaints if but not in line] == []


def until(page: "Page", true: Callable[[], object], within_s: float = WITHIN_S) -> None:
    """Waits until it is true. The page lives on meanwhile; its policy lets Playwright's own
    `wait_for_function` wait for nothing."""
    for _ in range(round(1000 * within_s / EVERY_MS)):
        if true():
            return
        page.wait_for_timeout(EVERY_MS)
    raise AssertionError("it does not come to be")
