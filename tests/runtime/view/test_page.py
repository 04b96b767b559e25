"""The operator's page in a real Chromium: what it shows of what it is told, and what it asks."""

import re

import numpy as np
import page_home as home
from chromium import needs_chromium, page_at, until
from page_double import serving

from runtime.map_look import room_tint

pytestmark = list(needs_chromium)
SPOILT = '<img src=x onerror="document.title=1">'


def text(page, selector: str, has: str) -> str:
    """The text there, once `has` is in it."""
    found = page.locator(selector).filter(has_text=has).first
    found.wait_for()
    return found.inner_text()


def known_m2(page) -> int:
    """What the map says of itself."""
    told = re.search(r"(\d+) square", page.get_attribute("#map", "aria-label"))
    return int(told[1]) if told else 0


def test_it_tells_what_the_robot_does_and_why(told):
    _, page = told
    assert "a red mug" in text(page, "#now", "a red mug")
    assert "6.1 m" in text(page, "#now-figures", "way")
    why = text(page, "#why-body", "Frontier 7")
    assert "3.4 m on foot: two of them name it." in why
    assert "3.4 m on foot, first of 3 in the planned order." in why
    assert "model on the robot, 0.34 s" in why
    assert "sink, towel near it" in why
    assert "58 %" in why
    assert "against 12" in why
    assert "all views look alike" in why  # who did not vote
    assert "Without objects near by\nfrontier 11" in why
    assert "Without kind of room or look of the view\nthe same" in why
    assert page.title() == "a red mug · RF-NAV"


def test_the_map_appears_and_grows(told):
    double, page = told
    double.show_map(*home.cells(0.5), home.X0_M, home.Y0_M)
    until(page, lambda: 0 < known_m2(page) < 45)
    small_m2 = known_m2(page)
    double.show_map(*home.cells(1.0), home.X0_M, home.Y0_M)
    until(page, lambda: known_m2(page) > small_m2 + 10)
    seen = page.evaluate(
        """() => { const c = document.getElementById('map'), n = new Set();
        const d = c.getContext('2d').getImageData(0, 0, c.width, c.height).data;
        for (let i = 0; i < d.length; i += 4) n.add(d[i] << 16 | d[i + 1] << 8 | d[i + 2]);
        return [...n]; }"""
    )
    assert {0xE6E2D9, 0x343A44} <= set(seen)  # unknown, and walls
    for name in home.ROOMS:
        tint = np.array(room_tint(name))
        away = min(np.abs(tint - [one >> 16, one >> 8 & 255, one & 255]).max() for one in seen)
        assert away <= 2, name  # Chromium rounds on the way
    assert page.locator("#map-empty").is_hidden()


def test_the_camera_is_shown_with_names_and_only_while_it_is_looked_at(told):
    double, page = told
    page.wait_for_selector('#camera-picture[aria-label="What the camera sees: mug"]')
    assert double.sent("watch")[-1] == {"kind": "watch", "camera": True, "hidden": False}
    page.wait_for_selector("#camera-note >> text=/This picture is [3-9] s old/")
    double.show_picture(home.picture(), 640, 480)
    page.wait_for_selector("#camera-note", state="hidden")


def test_a_goal_is_asked_for_with_what_was_chosen(told):
    double, page = told
    double.answers["goal"] = {"accepted": True, "id": "1", "how": "mug, as it is", "queued": 0}
    assert page.locator("#names option").count() == 4
    page.click("#goal-more")
    page.fill("#goal-minutes", "5")
    page.check("#goal-return")
    page.select_option("#goal-where", "room kitchen")
    page.fill("#goal-text", " a blue mug ")
    page.press("#goal-text", "Enter")
    text(page, "#toasts", "mug, as it is")
    assert double.did("goal") == [
        {
            "goal": "a blue mug",
            "limits": {"time_s": 300},
            "afterwards": "return",
            "area": {"room": "kitchen"},
        }
    ]


def test_a_goal_that_is_refused_is_said_and_stays_to_be_mended(told):
    double, page = told
    double.answers["goal"] = {"accepted": False, "code": 4720, "error": "goal: names no thing"}
    page.fill("#goal-text", "xyz")
    page.click("#goal-go")
    text(page, "#toasts", "names no thing")
    assert page.input_value("#goal-text") == "xyz"


def test_a_search_is_paused_resumed_and_cancelled(told):
    double, page = told
    page.click("#pause")
    text(page, "#toasts", "Paused")
    paused = {**home.state()["goal"], "paused": "asked"}
    double.say("state", **home.state("paused", "asked", goal=paused))
    page.click("#pause >> text=Go on")
    page.click("#cancel")
    text(page, "#toasts", "Cancelled")
    assert [m["what"] for m in double.sent("do")] == ["pause", "resume", "cancel"]
    double.say("state", **home.state("ready", goal=None))
    page.wait_for_selector("#cancel:disabled")


def test_a_goal_that_waits_is_cancelled_by_itself(told):
    double, page = told
    waiting = [{"id": "b2", "goal": "a bed"}, {"id": "c3", "goal": "a sofa"}]
    double.say("state", **home.state(queue=waiting))
    page.wait_for_selector("#cancel >> text=Cancel all")
    page.click("#tab-things")
    page.get_by_role("button", name="Cancel a sofa, which waits").click()
    text(page, "#toasts", "a sofa is not looked for")
    double.say("state", **home.state(queue=waiting[:1]))
    until(page, lambda: page.locator("#queue-list button").count() == 1)
    double.say("state", **home.state())
    page.wait_for_selector("#queue", state="hidden")
    assert double.did("cancel") == [{"id": "c3"}]


def test_why_it_stands_is_said_above_all_with_what_to_do(told):
    double, page = told
    double.say("state", **home.state("held", "frame: no image for 0.6 s"))
    said = text(page, "#notice", "Held.")
    assert "No image for 0.6 s." in said
    assert "Look whether the camera's driver runs" in said
    for topic in ("camera/depth/image_raw", "odom"):
        streams = {topic: {"per_s": 0.0, "age_s": 2.0, "bad": 0}}
        double.say("health", **{**home.health(), "streams": streams})
        double.say("state", **home.state("held", f"frame: {topic}: nothing received in 2 s"))
        assert f"Held. {topic}: nothing received in 2 s." in text(page, "#notice", topic)
    last = {"id": "9", "result": "found", "sentence": "found a red mug", "at_xy": [5.4, -2.9]}
    double.say("state", **home.state("ready", goal=None, last=last))
    assert "Found a red mug." in text(page, "#notice", "Found.")
    page.click("#notice-key")
    page.wait_for_selector("#notice", state="hidden")


def test_what_holds_it_for_a_moment_does_not_move_the_map(told):
    double, page = told
    for _ in range(4):
        double.say("state", **home.state("held", "overrun: control stood still for 0.3 s"))
        page.wait_for_timeout(100)
        assert page.locator("#notice").is_hidden()
        double.say("state", **home.state())
        page.wait_for_timeout(100)
    double.say("state", **home.state("stopped", "the page"))  # this is told at once
    page.wait_for_selector("#notice >> text=Stopped.")


def test_why_no_goal_is_taken_is_said_before_one_is_asked_for(told):
    double, page = told
    why = "nobody knows where keep-out zones lie"
    double.say("state", **home.state("ready", goal=None, refuses=why))
    assert "Nobody knows where" in text(page, "#notice", "No goal is taken.")
    double.say("places", places=[{"name": "dock", "xy": None}], memory="not known")
    page.click("#tab-things")
    page.get_by_role("button", name="The robot stands at dock").click()
    text(page, "#toasts", "It stands at dock")
    assert double.did("places") == [{"i_am_at": "dock"}]


def test_another_search_ends_looking_back_at_the_one_before(told):
    double, page = told
    double.answers["decision"] = lambda body: home.decision(body["number"], 3)
    page.focus("#scrub")
    page.keyboard.press("ArrowLeft")
    text(page, "#scrub-told", "Decision 3 of 4, then")
    double.say("timeline", id="b2", goal="a red mug", decisions=[], stops=[])
    text(page, "#scrub-told", "No decision yet")
    assert page.locator("#live").is_disabled()


def test_a_decision_of_before_is_looked_at_and_left_again(told):
    double, page = told
    double.answers["decision"] = lambda body: home.decision(body["number"], 3)
    page.focus("#scrub")
    page.keyboard.press("ArrowLeft")
    assert "Frontier 3" in text(page, "#why-body", "Decision 3")
    assert text(page, "#scrub-told", "then") == "Decision 3 of 4, then"
    double.say("decision", **home.decision(5, 12))  # what comes meanwhile does not take it away
    double.say("timeline", **home.timeline(5))
    text(page, "#scrub-told", "of 5")
    assert page.locator("#why-body").inner_text().count("Frontier 3") == 1
    page.click("#live")
    assert "Frontier 12" in text(page, "#why-body", "Decision 5")


def test_what_lies_on_the_map_can_be_read_and_gone_to(told):
    double, page = told
    page.click("#tab-things")
    assert text(page, "#things-list li >> nth=0", "mug").startswith("mug\nkitchen")
    assert "34 %" in text(page, "#belief-list", "mugs are by sinks")
    page.get_by_role("button", name="Go to dock").click()
    page.get_by_role("button", name="Remove the zone rug").click()
    text(page, "#toasts", "rug is open again")
    assert double.did("goal") == [{"go_to": "dock"}]
    assert double.did("zones") == [{"remove": "rug"}]


def test_health_has_stages_against_their_budgets(told):
    _, page = told
    page.click("#tab-health")
    assert "455 of 400" in text(page, "#stages .over", "455")
    assert page.locator("#stages .over").count() == 1
    assert "no cloud" in text(page, "#facts", "Money")


def test_a_robot_that_is_lost_is_unmistakable_and_found_again(told):
    double, page = told
    double.say("state", **home.state(link="no service", age_s=12.0, why="nobody answers"))
    assert "What is shown is 12 s old." in text(page, "#stale", "Nobody answers.")
    assert "grayscale" in page.evaluate("getComputedStyle(document.getElementById('map')).filter")
    assert page.locator("#pause").is_disabled()
    double.drop()
    text(page, "#stale", "No connection to rfnav view.")
    text(page, "#stale", "Nobody answers.")  # connected again, to who knows no more
    assert len(double.sent("hello")) == 2
    double.say("state", **home.state())
    page.wait_for_selector("#stale", state="hidden")


def test_a_page_that_is_sent_away_says_why_and_comes_again(browser):
    with serving() as double:
        double.full = True
        with page_at(browser, double.url) as page:
            text(page, "#stale", "Too many pages are open.")
            double.full = False
            page.wait_for_selector("#stale", state="hidden")


def test_a_token_is_asked_for_and_kept_out_of_the_address(browser):
    with serving(token="sesame") as double:
        with page_at(browser, double.url) as page:
            page.fill("#token-input", "wrong")
            page.press("#token-input", "Enter")
            until(page, lambda: page.input_value("#token-input") == "")
            page.fill("#token-input", "sesame")
            page.press("#token-input", "Enter")
            page.wait_for_selector('body[data-link="none"]')
            page.reload()
            page.wait_for_selector('body[data-link="none"]')
        with page_at(browser, f"{double.url}#token=sesame") as page:
            page.wait_for_selector('body[data-link="none"]')
            assert page.url == double.url
        tokens = [hello["token"] for hello in double.sent("hello")]
        assert tokens == [None, "wrong", "sesame", "sesame", "sesame"]


def test_what_others_say_is_text_and_never_markup(told):
    double, page = told
    thing = {**home.scene()["things"][0], "name": SPOILT, "room": SPOILT}
    double.say("scene", **home.scene(things=[thing]))
    double.say("zones", zones=[home.zone(SPOILT, 0, 0, 1, 1)], bound=True)
    double.say("places", places=[{"name": SPOILT, "xy": None}], memory="none")
    double.say("state", **home.state("held", SPOILT, queue=[{"id": "2", "goal": SPOILT}]))
    vote = {**home.decision()["votes"][0], "expert": SPOILT, "reason": SPOILT, "reasons": []}
    double.say("decision", **{**home.decision(6), "votes": [vote], "full": [SPOILT]})
    double.say("names", names=[SPOILT])
    page.click("#tab-things")
    text(page, "#places-list", SPOILT)
    text(page, "#now", SPOILT)
    page.click("#tab-why")
    text(page, "#why-body", SPOILT)
    assert page.locator("img").count() == 0


def test_a_recording_is_played_and_sought_in_and_nothing_is_asked_of_the_robot(browser):
    with serving() as double:
        double.welcome |= {
            "mode": "replay",
            "file": "drive.mcap",
            "can": {"teleop": False, "command": False, "camera": True},
        }
        with page_at(browser, double.url) as page:
            home.tell_all(double)
            told = [{"number": 1, "t_s": 1010.0, "frontier": 4, "in_words": "frontier 4"}]
            double.say("span", from_s=1000.0, to_s=1060.0, goals=[], decisions=told, stops=[])
            double.say("at", t_s=1006.0, speed=0)
            assert text(page, "#scrub-told", "of") == "6 s of 60 s"
            double.say("decision", number=0)
            text(page, "#why-body", "Nothing was decided yet.")
            for hidden in ("#stop", "#goal", "#pause", ".tools", "#tab-drive"):
                assert page.locator(hidden).is_hidden()
            page.keyboard.press("Space")
            page.click("#play")
            page.focus("#scrub")
            page.keyboard.press("End")
            page.wait_for_timeout(400)
        assert double.sent("play") == [{"kind": "play", "speed": 1}]
        assert double.sent("seek") == [{"kind": "seek", "t_s": 1060.0}]
        assert double.sent("do") == []
        assert double.posted == 0
