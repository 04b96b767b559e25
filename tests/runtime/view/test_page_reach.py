"""Who can use the operator's page: on a telephone, in the sun and in the dark, by keys alone, with
a screen reader."""

from collections.abc import Iterator

import page_home as home
import pytest
from chromium import TELEPHONE, needs_chromium, page_at, until
from page_double import PageDouble, serving

pytestmark = list(needs_chromium)
LEAST_CONTRAST, LARGE_CONTRAST = 4.5, 3.0
LEAST_TOUCH_PX = 40
TABS = "why", "camera", "things", "drive", "health"
# Every text that is seen, with its colour over what it stands on: [contrast, large, text].
CONTRASTS = """() => {
  const linear = v => (v /= 255) <= 0.04045 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4;
  const light = c => 0.2126 * linear(c[0]) + 0.7152 * linear(c[1]) + 0.0722 * linear(c[2]);
  const parsed = s => { const n = s.match(/[\\d.]+/g).map(Number);
    return s.startsWith('color(') ? [...n.slice(0, 3).map(v => 255 * v), n[3] ?? 1] : n; };
  const over = (top, under) => { const a = top[3] ?? 1;
    return [0, 1, 2].map(i => a * top[i] + (1 - a) * under[i]); };
  const ground = node => { const layers = [];
    for (let at = node; at; at = at.parentElement)
      layers.push(parsed(getComputedStyle(at).backgroundColor));
    return layers.reverse().reduce((under, top) => over(top, under), [255, 255, 255]); };
  const found = [], walk = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
  while (walk.nextNode()) {
    const node = walk.currentNode.parentElement, box = node.getBoundingClientRect();
    if (!walk.currentNode.data.trim() || box.width < 2 || !node.checkVisibility()) continue;
    if (node.closest('.hidden, :disabled, option, script')) continue;
    const style = getComputedStyle(node), under = ground(node);
    const [a, b] = [light(over(parsed(style.color), under)), light(under)].sort((x, y) => y - x);
    const px = parseFloat(style.fontSize);
    found.push([(a + 0.05) / (b + 0.05), px >= 24 || (px >= 18.6 && style.fontWeight >= 700),
      `${walk.currentNode.data.trim()} (${style.color} on ${under})`]);
  }
  return found;
}"""
# What can be pressed, typed in or moved and has no name to say.
NAMELESS = """() => [...document.querySelectorAll(
    'button, input, select, a, canvas, dialog, [role], [tabindex]')]
  .filter(e => e.checkVisibility() && !e.closest('[aria-hidden=true]'))
  .filter(e => !['status', 'alert'].includes(e.role))
  .filter(e => { const by = e.getAttribute('aria-labelledby');
    return !(e.ariaLabel || e.textContent.trim() || e.labels?.length
      || (by && document.getElementById(by)?.textContent.trim())); })
  .map(e => e.outerHTML.slice(0, 120))"""


@pytest.fixture(scope="module")
def double() -> Iterator[PageDouble]:
    with serving() as made:
        home.tell_all(made)
        yield made


@pytest.mark.parametrize("theme", ["light", "dark"])
@pytest.mark.parametrize("telephone", [False, True])
def test_every_text_can_be_read(browser, double, theme, telephone):
    with page_at(browser, double.url, telephone, color_scheme=theme) as page:
        page.wait_for_selector("#now[data-any]")
        faint, seen = [], 0
        for state, cause in (("searching", ""), ("held", "frame: old"), ("stopped", "the page")):
            double.say("state", **home.state(state, cause))
            page.wait_for_timeout(300)  # colours fade in
            for tab in TABS:
                if page.locator(f"#tab-{tab}").is_visible():
                    page.click(f"#tab-{tab}")
                    told = page.evaluate(CONTRASTS)
                    seen += len(told)
                    faint += [t for t in told if t[0] < _least(t[1])]
        double.say("state", **home.state())
    assert faint == []
    assert seen > 200


def _least(large: bool) -> float:
    return LARGE_CONTRAST if large else LEAST_CONTRAST


@pytest.mark.parametrize("telephone", [False, True])
def test_everything_has_a_name_to_say(browser, double, telephone):
    with page_at(browser, double.url, telephone) as page:
        page.wait_for_selector("#now[data-any]")
        nameless = page.evaluate(NAMELESS)
        for tab in TABS:
            if page.locator(f"#tab-{tab}").is_visible():
                page.click(f"#tab-{tab}")
                nameless += page.evaluate(NAMELESS)
        assert nameless == []
        assert page.evaluate("document.documentElement.lang") == "en"
        headings = page.locator("h1, h2").all_inner_texts()
        assert headings


def test_what_changes_is_said(browser, double):
    with page_at(browser, double.url) as page:
        page.wait_for_selector("#now[data-any]")
        assert page.get_attribute("#now-does", "aria-live") == "polite"
        assert page.get_attribute("#notice", "role") == "alert"
        assert page.get_attribute("#toasts", "role") == "status"
        page.wait_for_selector('#scrub[aria-valuetext="Decision 4, now"]')


def test_a_keyboard_reaches_everything_in_order_and_moves_the_map(browser, double):
    with page_at(browser, double.url) as page:
        page.wait_for_selector("#now[data-any]")
        page.wait_for_selector("#map-empty", state="hidden")
        reached = []
        for _ in range(40):
            page.keyboard.press("Tab")
            reached.append(page.evaluate("document.activeElement.id || 'other'"))
        wanted = ["goal-text", "goal-go", "pause", "cancel", "stop", "map", "zoom-in", "tab-why"]
        assert [one for one in reached if one in wanted][: len(wanted)] == wanted
        assert "scrub" in reached
        page.focus("#tab-why")
        page.keyboard.press("ArrowRight")
        assert page.evaluate("document.activeElement.id") == "tab-things"
        assert page.locator("#things").is_visible()
        page.focus("#map")
        page.keyboard.press("ArrowRight")
        page.wait_for_selector('#follow[aria-pressed="false"]')
        page.keyboard.press("f")
        page.wait_for_selector('#follow[aria-pressed="true"]')


def test_on_a_telephone_all_is_in_reach_and_stop_is_under_the_thumb(browser, double):
    with page_at(browser, double.url, telephone=True) as page:
        page.wait_for_selector("#now[data-any]")
        wide = page.evaluate("document.documentElement.scrollWidth")
        assert wide <= TELEPHONE["width"]
        stop = page.locator("#stop").bounding_box()
        assert stop["width"] >= 150
        assert stop["height"] >= 60
        assert TELEPHONE["height"] - 100 < stop["y"] + stop["height"] <= TELEPHONE["height"]
        for tab in TABS:
            page.tap(f"#tab-{tab}")
            assert page.locator(f"#{tab}").is_visible()
            small = [
                box
                for button in page.locator("button:visible:not(.chip, .rows button)").all()
                if min((box := button.bounding_box())["width"], box["height"]) < LEAST_TOUCH_PX
            ]
            assert small == []
        page.tap("#stop")
        page.wait_for_selector('#stop[data-state="stopped"]')
        assert double.did("stop")


@pytest.mark.parametrize(("width", "height"), [(844, 390), (932, 430), (320, 568), (768, 1024)])
def test_on_other_screens_stop_map_and_panels_have_room(browser, double, width, height):
    size = {"width": width, "height": height}
    with page_at(browser, double.url, telephone=True, viewport=size) as page:
        page.wait_for_selector("#now[data-any]")
        assert page.evaluate("document.documentElement.scrollWidth") <= width
        stop, seen = page.locator("#stop").bounding_box(), page.locator("#map").bounding_box()
        panel = page.locator("#why").bounding_box()
        assert stop["y"] + stop["height"] <= height
        assert min(stop["width"], 3 * stop["height"]) >= 130
        assert min(seen["width"], seen["height"], panel["width"], panel["height"]) >= 120


def test_two_fingers_zoom_the_map(browser, double):
    with page_at(browser, double.url, telephone=True) as page:
        page.wait_for_selector("#map-empty", state="hidden")
        box = page.locator("#map").bounding_box()
        x, y = box["x"] + 150, box["y"] + 250
        picture = "document.getElementById('map').toDataURL()"
        before = page.evaluate(picture)
        fingers = page.context.new_cdp_session(page)
        for kind, apart in (("touchStart", 40), ("touchMove", 60), ("touchMove", 120)):
            points = [{"x": x - apart, "y": y, "id": 0}, {"x": x + apart, "y": y, "id": 1}]
            fingers.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": points})
        fingers.send("Input.dispatchTouchEvent", {"type": "touchEnd", "touchPoints": []})
        page.wait_for_selector('#follow[aria-pressed="false"]')
        until(page, lambda: page.evaluate(picture) != before)


def test_nothing_moves_for_who_wants_no_motion(browser, double):
    with page_at(browser, double.url, reduced_motion="reduce") as page:
        page.wait_for_selector("#now[data-any]")
        page.click("#pause")
        page.wait_for_selector("#toasts p")
        moving = page.evaluate("document.getAnimations().length")
        slow = page.evaluate(
            "getComputedStyle(document.getElementById('pause')).transitionDuration"
        )
        assert (moving, slow) == (0, "0s")
