"""A search's decisions and stops, as a page goes back through them."""

import pytest

from runtime.view.history import DECISIONS_KEPT, STOPS_KEPT, SearchHistory


def decision(number: int, goal: str = "mug") -> dict[str, object]:
    words = {"frontier": number + 10, "in_words": f"to {number}", "votes": []}
    return {"number": number, "id": f"id of {goal}", "goal": goal, **words}


def numbers(history: SearchHistory) -> list[int]:
    return [one["number"] for one in history.timeline()["decisions"]]


def stop(number: int, over: bool = False) -> dict[str, object]:
    return {"number": number, "state": "held", "halt": "contact", "reason": "r", "over": over}


def test_a_decision_is_kept_with_the_scene_of_its_time():
    history = SearchHistory()
    history.decided(decision(1), '{"goal": "mug"}', 5.0)
    history.decided(decision(2), "", 6.0)
    assert history.decision(1) == {**decision(1), "t_s": 5.0, "scene": {"goal": "mug"}}
    assert history.decision(2)["scene"] is None
    assert [one["number"] for one in history.timeline()["decisions"]] == [1, 2]


@pytest.mark.parametrize("number", [9, "1", None, [1]])
def test_one_that_was_not_seen_is_told_as_such(number: object):
    history = SearchHistory()
    history.decided(decision(1), "", 5.0)
    with pytest.raises(ValueError, match="was not seen"):
        history.decision(number)


def test_another_search_begins_another_timeline():
    history = SearchHistory()
    for n in (1, 2, 3):
        history.decided(decision(n), "", 1.0)
    history.decided({**decision(1), "id": "b2"}, "", 2.0)  # the same thing once more
    assert numbers(history) == [1]
    history.decided(decision(2, "cup"), "", 2.0)
    assert history.timeline()["goal"] == "cup"
    assert numbers(history) == [2]


def test_one_whose_words_come_late_is_put_in_its_place():
    history = SearchHistory()
    for n in (1, 3, 2):
        assert history.decided(decision(n), "", 1.0)
    assert numbers(history) == [1, 2, 3]
    assert history.last == 3


def test_one_that_is_known_with_its_votes_is_not_told_again_in_words_alone():
    history, words = SearchHistory(), {**decision(1), "full": ["Taken: frontier 3."]}
    words.pop("votes")
    assert history.decided(words, "", None)
    assert history.decided(decision(1), "", 5.0)
    assert not history.decided(words, "", None)
    assert history.decision(1) == {**decision(1), "t_s": 5.0, "scene": None}


def test_what_is_kept_is_bounded():
    history = SearchHistory()
    for n in range(1, 2 * DECISIONS_KEPT):
        history.decided(decision(n), "", 1.0)
        history.stopped(stop(n), 1.0)
    line = history.timeline()
    assert len(line["decisions"]) == DECISIONS_KEPT
    assert len(line["stops"]) == STOPS_KEPT


def test_a_stop_is_news_when_it_begins_and_when_it_ends():
    history = SearchHistory()
    assert history.stopped(stop(1), 5.0)
    assert not history.stopped(stop(1), 6.0)
    assert history.stopped(stop(1, over=True), 7.0)
    assert history.timeline()["stops"][0]["t_s"] == 5.0


def test_only_the_last_stop_can_go_on():
    """The end of one that was followed by another at once was never told."""
    history = SearchHistory()
    history.stopped(stop(1), 5.0)
    history.stopped(stop(2), 6.0)
    assert [one["over"] for one in history.timeline()["stops"]] == [True, False]


def test_a_service_that_was_started_anew_counts_from_the_beginning():
    history = SearchHistory()
    history.decided(decision(5), "", 1.0)
    history.stopped(stop(2), 1.0)
    history.forget()
    history.decided(decision(1), "", 2.0)  # the same goal, which was kept over the restart
    history.stopped(stop(1), 9.0)
    assert numbers(history) == [1]
    assert [one["number"] for one in history.timeline()["stops"]] == [1]
