"""Two values of JSON are compared leaf by leaf."""

import numpy as np

from runtime.replay.differences import Differences
from runtime.replay.script import Turn

TURN = Turn(7, "frame", 3.25)


def found(kind: str, replayed: object, recorded: object) -> list[str]:
    differences = Differences()
    differences.compare(TURN, kind, replayed, recorded)
    return [d.in_words() for d in differences.found]


def test_what_differs_is_named_by_its_path():
    recorded = {"action": "turn_left", "toward_xy": [1.0, 2.0], "frontiers": [[1, 0.5]]}
    assert found("command", recorded, dict(recorded)) == []
    assert found("command", recorded | {"frontiers": [[1, 0.5000000001]]}, recorded) == [
        "turn 7, 3.25 s: command.frontiers[0][1] is 0.5000000001, was 0.5"
    ]
    assert found("command", recorded | {"toward_xy": None}, recorded) == [
        "turn 7, 3.25 s: command.toward_xy is nothing, was [1.0, 2.0]"
    ]


def test_one_more_or_one_less():
    differences = Differences()
    turn = Turn(1, "frame", 0.0, made={"decision": [{"frontier": 3}, {"frontier": 4}]})
    differences.compare_turn(turn, {"decision": [{"frontier": 3}]})
    (one,) = differences.found
    assert one.in_words() == "turn 1, 0.00 s: decision is nothing, was {'frontier': 4}"
    assert differences.compared == {"decision": 2}
    cut = Differences()
    cut.compare_turn(turn, {"decision": [{"frontier": n} for n in (3, 4, 5)]}, cut=True)
    assert not cut.found


def test_arrays_by_their_bytes():
    differences = Differences()
    a = np.arange(100.0)
    recorded = {"path_xy": {"dtype": "float64", "shape": [100], "base64": "AAAA"}}
    differences.compare(TURN, "command", {"path_xy": a}, recorded)
    assert [d.what for d in differences.found] == ["command.path_xy"]


def test_what_a_clock_says_is_not_compared():
    told = {"sent": {"v_mps": 0.1}, "late_s": 0.0}
    assert found("tick", told, told | {"late_s": 0.02}) == []
    assert len(found("tick", told, {"sent": {"v_mps": 0.2}, "late_s": 0.0})) == 1


def test_the_end_of_the_runtime_is_no_difference():
    differences = Differences()
    differences.compare_turn(Turn(1, "frame", 0.0, made={"rest": [{"state": "ended"}]}), {})
    assert not differences.found
    differences.compare_turn(Turn(1, "frame", 0.0, made={"rest": [{"state": "found"}]}), {})
    assert len(differences.found) == 1


def test_questions_are_compared_whenever_they_were_told():
    differences = Differences()
    asked = [{"why": "first decision"}, {"why": "new evidence"}]
    differences.compare_turn(Turn(1, "frame", 0.0, made={"question": asked[:1]}), {})
    differences.compare_turn(Turn(2, "frame", 0.1), {"question": asked[:1]})
    assert (differences.found, differences.compared) == ([], {"question": 1})
    differences.compare_turn(Turn(3, "frame", 0.2), {"question": asked[1:]})
    differences.compare_turn(Turn(4, "frame", 0.3, made={"question": [{"why": "gone"}]}), {})
    assert [d.what for d in differences.found] == ["question.why"]
