"""The operator's page in a real Chromium: stopping, driving by hand, drawing on the map."""

import re

import page_home as home
import pytest
from chromium import needs_chromium, page_at, until
from page_double import serving

pytestmark = list(needs_chromium)
PAD = """navigator.getGamepads = () => [{axes: [0, -1], buttons: Array.from({length: 17},
(_, i) => ({pressed: i === 5 && window.held}))}]"""

FAR_PX = 300.0, 700.0  # two points of the page over the map, both ways


def pointed(page, px: float) -> tuple[float, float]:
    """What the map tells, m, of the point (px, px) of the page."""
    page.mouse.move(px, px)
    x, y = re.findall(r"-?\d+\.\d+", page.locator("#pointed").inner_text())
    return float(x), float(y)


def at(page, x: float, y: float) -> tuple[float, float]:
    """Where a point of the map, m, is on the page, px."""
    near, far = FAR_PX
    (x0, y0), (x1, y1) = pointed(page, near), pointed(page, far)
    return (
        near + (x - x0) * (far - near) / (x1 - x0),
        near + (y - y0) * (far - near) / (y1 - y0),
    )


# -- stop ------------------------------------------------------------------------------------------


@pytest.mark.parametrize("focus", ["body", "#pause", "#map", "#scrub", "#tab-why", "#stop"])
def test_the_space_bar_stops_wherever_one_is_and_presses_nothing_else(told, focus):
    double, page = told
    if focus != "body":
        page.focus(focus)
    page.keyboard.press("Space")
    until(page, lambda: double.did("stop") and double.posted)
    page.wait_for_selector('#stop[data-state="stopped"]')
    assert {m["what"] for m in double.sent("do")} == {"stop"}


def test_the_space_bar_writes_a_blank_and_ticks_where_one_fills_in(told):
    double, page = told
    page.focus("#goal-text")
    page.keyboard.type("a mug")
    assert page.input_value("#goal-text") == "a mug"
    page.click("#goal-more")
    page.focus("#goal-return")
    page.keyboard.press("Space")
    assert page.is_checked("#goal-return")
    assert double.did("stop") == []


def test_a_touch_stops_before_the_finger_is_lifted_and_does_not_release(told):
    double, page = told
    box = page.locator("#stop").bounding_box()
    x, y = box["x"] + 20, box["y"] + 20
    page.mouse.move(x, y)
    page.mouse.down()
    until(page, lambda: double.did("stop"))
    double.say("state", **home.state("stopped", "the page"))
    page.mouse.up()
    page.wait_for_selector("#notice >> text=It stays so until it is released.")
    assert page.locator("#release-ask").is_hidden()


def test_a_stop_that_nobody_confirms_is_asked_again_and_said_aloud(browser):
    with serving() as double, page_at(browser, double.url, but="503") as page:
        home.tell_all(double)
        page.wait_for_selector("#now[data-any]")
        double.silent = True
        page.keyboard.press("Space")
        page.wait_for_selector("#notice >> text=Use the switch on the robot")
        assert page.locator("#stop b").inner_text() == "NOT confirmed"
        assert len(double.did("stop")) >= 3
        double.silent = False
        page.wait_for_selector('#stop[data-state="stopped"]')
        double.say("state", **home.state("stopped", "the page"))
        page.wait_for_selector("#notice >> text=It stays so until it is released")


def test_a_robot_that_was_stopped_when_it_was_lost_is_stopped_again(told):
    double, page = told
    double.say("state", **home.state("stopped", "the page"))
    page.wait_for_selector('#stop[data-state="stopped"]')
    lost = home.state("stopped", "the page", link="no service", age_s=9.0, why="nobody answers")
    double.say("state", **lost)  # somebody else may have released it since
    page.click('#stop[data-state="ready"]')
    until(page, lambda: double.did("stop") and double.posted)
    assert page.locator("#release-ask").is_hidden()


def test_it_is_released_by_a_second_step_and_not_by_the_space_bar(told):
    double, page = told
    double.say("state", **home.state("stopped", "the page"))
    page.click('#stop[data-state="stopped"]')
    page.wait_for_selector("#release-ask[open]")
    assert page.evaluate("document.activeElement.id") == "release-no"
    assert double.did("release") == []
    page.keyboard.press("Space")
    page.wait_for_selector("#release-ask", state="hidden")
    until(page, lambda: double.did("stop"))
    page.wait_for_timeout(900)
    page.click("#stop")
    page.click("#release-yes")
    until(page, lambda: double.did("release"))


# -- by hand ---------------------------------------------------------------------------------------


def test_keys_drive_while_it_is_taken_over_and_handing_back_ends_it(told):
    double, page = told
    page.click("#tab-drive")
    page.keyboard.press("w")
    page.wait_for_timeout(250)
    assert double.sent("teleop") == []  # nobody has taken over
    page.click("#drive-take")
    page.keyboard.down("w")
    page.keyboard.down("ArrowLeft")
    wanted = {"kind": "teleop", "v": 0.5, "w": 0.5}
    until(page, lambda: wanted in double.sent("teleop"))
    page.keyboard.up("w")
    page.keyboard.up("ArrowLeft")
    page.wait_for_timeout(250)
    assert double.sent("teleop")[-1] == {"kind": "teleop", "v": 0, "w": 0}  # it is held still
    page.click("#drive-take")
    ended = {"kind": "teleop", "v": 0, "w": 0, "end": True}
    until(page, lambda: double.sent("teleop")[-1] == ended)
    page.wait_for_timeout(250)
    assert double.sent("teleop")[-1] == ended


def test_the_stick_drives_and_springs_back(told):
    double, page = told
    page.click("#tab-drive")
    page.click("#drive-take")
    box = page.locator("#pad").bounding_box()
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x, y - box["height"])
    until(page, lambda: {"kind": "teleop", "v": 0.5, "w": 0} in double.sent("teleop"))
    page.mouse.up()
    until(page, lambda: double.sent("teleop")[-1] == {"kind": "teleop", "v": 0, "w": 0})


def test_a_window_that_loses_the_focus_drives_nowhere(told):
    double, page = told
    page.click("#tab-drive")
    page.click("#drive-take")
    page.keyboard.down("w")
    until(page, lambda: any(m["v"] for m in double.sent("teleop")))
    page.evaluate("window.dispatchEvent(new Event('blur'))")
    until(page, lambda: double.sent("teleop")[-1]["v"] == 0)


def test_a_robot_that_is_stopped_or_in_another_hand_is_not_driven(told):
    double, page = told
    ended = {"kind": "teleop", "v": 0, "w": 0, "end": True}
    page.click("#tab-drive")
    for held, note in (
        (home.state("stopped", "the page"), "It is stopped: release it first."),
        (home.state(teleop=2), "Somebody else has the sticks."),
    ):
        double.say("state", **home.state(teleop=1))
        page.click("#drive-take:enabled")
        page.wait_for_selector("#drive-note >> text=You drive")
        double.say("state", **held)
        page.wait_for_selector(f"#drive-note >> text={note}")
        until(page, lambda: double.sent("teleop")[-1] == ended)
        assert page.locator("#drive-take").is_disabled()


def test_a_gamepad_drives_while_its_shoulder_key_is_held(told):
    double, page = told
    page.evaluate(f"() => {{ {PAD} }}")
    page.evaluate("() => { window.held = true; }")
    until(page, lambda: {"kind": "teleop", "v": 0.5, "w": 0} in double.sent("teleop"))
    page.evaluate("() => { window.held = false; }")
    until(page, lambda: double.sent("teleop")[-1].get("end"))


# -- drawing ---------------------------------------------------------------------------------------


def test_a_zone_is_drawn_by_its_corners(told):
    double, page = told
    page.click("[data-tool=zone]")
    for corner in ((1.0, -1.0), (2.0, -1.0), (1.5, -2.0)):
        page.mouse.click(*at(page, *corner))
    page.click("#drawing-done")
    page.fill("#name-input", "stairs")
    page.press("#name-input", "Enter")
    until(page, lambda: double.did("zones"))
    (asked,) = double.did("zones")
    assert asked["add"] == "stairs"
    flat = [v for corner in asked["polygon"] for v in corner]
    assert flat == pytest.approx([1.0, -1.0, 2.0, -1.0, 1.5, -2.0], abs=0.03)


def test_a_zone_is_drawn_as_a_box_and_the_map_stays_where_it_is(told):
    double, page = told
    page.click("[data-tool=zone]")
    before = pointed(page, 500.0)
    page.mouse.move(*at(page, 1.0, -1.0))
    page.mouse.down()
    page.mouse.move(*at(page, 2.0, -2.0), steps=5)
    page.mouse.up()
    page.get_by_role("button", name="Keep", exact=True).click()
    until(page, lambda: double.did("zones"))
    (asked,) = double.did("zones")
    assert asked["add"] == "zone 2"
    assert asked["polygon"][2] == pytest.approx([2.0, -2.0], abs=0.03)
    assert pointed(page, 500.0) == before


def test_a_zone_is_drawn_by_keys_alone(told):
    double, page = told
    page.focus("[data-tool=zone]")
    page.keyboard.press("Enter")
    page.focus("#map")
    for key in ("Enter", "ArrowRight", "Enter", "ArrowDown", "Enter", "d"):
        page.keyboard.press(key)
    page.keyboard.type("rug edge")
    page.keyboard.press("Enter")
    until(page, lambda: double.did("zones"))
    (asked,) = double.did("zones")
    (x0, y0), (x1, y1), (x2, y2) = asked["polygon"]
    assert asked["add"] == "rug edge"
    assert (x1 > x0, y1 == y0, x2 == x1, y2 < y1) == (True, True, True, True)


def test_what_is_discarded_asks_nothing(told):
    double, page = told
    page.click("[data-tool=zone]")
    page.mouse.click(*at(page, 1.0, -1.0))
    page.keyboard.press("Escape")
    page.wait_for_selector("#drawing", state="hidden")
    page.click("[data-tool=zone]")
    page.mouse.click(*at(page, 1.0, -1.0))
    page.click("#drawing-done")
    page.wait_for_selector("#drawing-text >> text=It takes three corners.")
    assert double.sent("do") == []


def test_the_next_goal_is_searched_for_in_the_area_that_was_drawn(told):
    double, page = told
    page.click("[data-tool=area]")
    page.mouse.move(*at(page, 4.5, -3.0))
    page.mouse.down()
    page.mouse.move(*at(page, 8.0, 0.0), steps=5)
    page.mouse.up()
    page.fill("#goal-text", "mug")
    page.click("#goal-go")
    until(page, lambda: double.did("goal"))
    (asked,) = double.did("goal")
    assert asked["area"]["polygon"][0] == pytest.approx([4.5, -3.0], abs=0.03)
    assert asked["area"]["polygon"][2] == pytest.approx([8.0, 0.0], abs=0.03)


def test_a_place_is_named_where_the_robot_stands_and_on_the_map(told):
    double, page = told
    page.click("[data-tool=place]")
    page.click("#drawing-done")
    page.fill("#name-input", "hall")
    page.press("#name-input", "Enter")
    until(page, lambda: double.did("places"))
    page.click("[data-tool=place]")
    page.mouse.click(*at(page, 2.0, -0.5))
    page.fill("#name-input", "sofa")
    page.press("#name-input", "Enter")
    until(page, lambda: len(double.did("places")) == 2)
    here, there = double.did("places")
    assert here == {"name": "hall"}
    assert there["name"] == "sofa"
    assert there["at"] == pytest.approx([2.0, -0.5, 0.0], abs=0.03)
