"""The goals that have not ended, and the file that they are kept in."""

import json
from pathlib import Path
from typing import Any

import pytest
from full_disk import largest_file

from runtime.errors import SavedError
from runtime.service.goal_queue import (
    FILE,
    WAITING,
    AskedGoal,
    GoalFile,
    GoalQueue,
    is_id,
    new_id,
    read_goals,
)


def goals(*names: str) -> list[AskedGoal]:
    return [AskedGoal(name, name, {"goal": name}) for name in names]


def test_goals_come_in_their_turn_and_whoever_keeps_them_knows_of_each_change():
    kept: list[list[tuple[str, bool, int]]] = []

    def keep(told: tuple[AskedGoal, ...]) -> None:
        kept.append([(goal.id, goal.paused, goal.begun) for goal in told])

    queue = GoalQueue(keep)
    first, *others = goals("a", "b", "c")
    queue.begin(first, others[:1])
    queue.wait(others[1:])
    queue.pause(True)
    assert queue.told() == [{"id": "b", "goal": "b"}, {"id": "c", "goal": "c"}]
    assert queue.drop("x") == ()
    assert queue.drop("b") == (others[0],)
    queue.ended()
    queue.pause(True)  # nothing is under way
    assert queue.next() == others[1]
    queue.begin(others[1])
    assert queue.next() is None
    queue.ended()
    assert kept == [
        [("a", False, 1), ("b", False, 0)],
        [("a", False, 1), ("b", False, 0), ("c", False, 0)],
        [("a", True, 1), ("b", False, 0), ("c", False, 0)],
        [("a", True, 1), ("c", False, 0)],
        [("c", False, 0)],
        [("c", False, 1)],
        [],
    ]


def test_there_is_room_for_some():
    queue = GoalQueue()
    assert queue.full(WAITING, True, WAITING) == ""
    queue.wait(goals("a"))
    assert queue.full(WAITING - 1, True, WAITING) == ""
    assert queue.full(WAITING, False, WAITING) == ""  # in the place of those that wait
    told = "goals that wait: 1 now, 3 with this, 2 at most: ask again when the next has begun, or "
    assert queue.full(2, True, 2) == f"{told}cancel one"
    told = "goals that wait: 0 now, 3 with this, 2 at most: ask for fewer"
    assert queue.full(3, False, 2) == told
    assert queue.drop() == tuple(goals("a"))


def test_what_is_kept_comes_back(tmp_path: Path):
    file = GoalFile(tmp_path)
    assert file.kept() == ()
    kept = (AskedGoal("a", "ein Becher", {"goal": "ein Becher", "limits": {}}, True, 2),)
    file.keep(kept)
    assert GoalFile(tmp_path).kept() == kept
    file.keep(())
    assert file.kept() == ()


def test_a_goal_that_has_ended_is_not_kept_by_a_disk_that_takes_nothing(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
):
    file = GoalFile(tmp_path)
    file.keep(tuple(goals("a", "b")))
    for left in (goals("b"), []):
        with largest_file(0):
            file.keep(tuple(left))
        assert file.kept() == ()
    assert "a restart will not know of 1 goals" in capsys.readouterr().err


def test_ids_are_each_their_own():
    made = {new_id() for _ in range(100)}
    assert len(made) == 100
    assert all(is_id(id) for id in made)
    assert not any(is_id(value) for value in ("", "a b", "a" * 65, 3, None, "é", "a/b"))


GOAL = {"id": "a1", "text": "bed", "body": {"goal": "bed"}, "paused": False, "begun": 1}


def test_a_goal_as_it_is_written_is_read():
    assert read_goals(json.dumps({"version": 1, "goals": [GOAL]}).encode()) == (
        AskedGoal("a1", "bed", {"goal": "bed"}, False, 1),
    )


@pytest.mark.parametrize(
    "told",
    [
        [], {}, {"version": 2, "goals": []}, {"version": 1, "goals": {}},
        {"version": 1, "goals": [GOAL] * (WAITING + 2)}, {"version": 1, "goals": [3]},
        *({"version": 1, "goals": [{**GOAL, **wrong}]} for wrong in (
            {"id": 3}, {"id": "a b"}, {"text": None}, {"body": []}, {"paused": "no"},
            {"begun": -1}, {"begun": 1.5}, {"begun": 10_000},
        )),
    ],
)  # fmt: skip
def test_what_is_no_list_of_goals_is_put_aside(tmp_path: Path, told: Any):
    (tmp_path / FILE).write_text(json.dumps(told))
    with pytest.raises(SavedError, match=r"goals\.json: .*put aside as goals\.json\.aside-1"):
        GoalFile(tmp_path).kept()
    assert not (tmp_path / FILE).exists()


def test_a_robot_goes_on_where_goals_cannot_be_kept(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
):
    (tmp_path / "state").write_text("a file")
    GoalFile(tmp_path / "state").keep(tuple(goals("a")))
    assert "goals.json: cannot be written" in capsys.readouterr().err
