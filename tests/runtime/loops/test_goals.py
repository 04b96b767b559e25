"""The life of a goal, from the request to the result, and over a restart."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from goal_bench import Bench

from runtime import navigate
from runtime.core.destination import Destination
from runtime.core.mapping.zones import Zone
from runtime.core.types import Action, SearchState
from runtime.core.world import Command, Mode
from runtime.errors import ConfigError
from runtime.journal import read_journal
from runtime.loops.goals import ASKED_ON, TRIES
from runtime.loops.whereabouts import NoZones
from runtime.service.bounds import ANYWHERE, AREA, GoalBounds
from runtime.service.goal_queue import FILE, WAITING
from runtime.service.outcomes import FailCause, GoalEnd

ENDS = GoalEnd(SearchState.ENDED, "the runtime ends", FailCause.RESTART)


@pytest.fixture
def made(tmp_path: Path) -> Iterator[Callable[..., Bench]]:
    """Makes one as it is told."""
    all_: list[Bench] = []

    def make(*settings: str, **more: Any) -> Bench:
        all_.append(Bench(tmp_path, *settings, **more))
        return all_[-1]

    yield make
    for bench in all_:
        bench.close()


@pytest.fixture
def bench(made: Callable[..., Bench]) -> Bench:
    return made()


def acts(monkeypatch: pytest.MonkeyPatch, ended: SearchState, why: str = "so it is") -> None:
    """The next frame ends the search like that."""
    stop = Command(Action.STOP, Mode.STOP, (4.5, 3.0), why, ended=ended)
    monkeypatch.setattr(navigate, "act", lambda world, cfg: stop)


def queue(bench: Bench) -> list[str]:
    told: Any = bench.life.told()["queue"]
    return [goal["goal"] for goal in told]


def under_way(bench: Bench) -> object:
    return bench.life.told()["goal"]


# -- one goal --------------------------------------------------------------------------------------


def test_a_goal_has_an_id_by_which_its_result_is_waited_for(bench: Bench):
    answer = bench.ask()
    assert {k: answer[k] for k in ("accepted", "name", "how", "queued", "log_dir")} == {
        "accepted": True, "name": "toilet", "how": "as it is", "queued": 0,
        "log_dir": str(bench.folder / "search"),
    }  # fmt: skip
    bench.frames(3)
    assert {told["id"] for told in bench.feedback} == {answer["id"]}
    now, asked = bench.request("result", id=answer["id"])
    newest, also = bench.request("result")
    assert (now, newest, asked.answers) == (None, None, [])
    summary, _ = bench.request("cancel", reason="enough")
    (told,), (again,) = asked.answers, also.answers
    assert told == again
    assert (told["result"], told["code"], told["reason"]) == ("cancelled", 4703, "enough")
    assert told["sentence"].startswith('"toilet" was cancelled: enough; ')
    assert summary is not None
    assert {**summary, **told} == summary | {"reason": "enough"}
    assert summary["ended"]
    assert bench.feedback[-1]["result"] == "cancelled"
    assert bench.result(answer["id"]) == told
    assert bench.life.told()["last"]["sentence"] == told["sentence"]  # type: ignore[index]
    assert bench.said[-1] == f"cancelled: {told['sentence']}"
    first, *_, last = read_journal(bench.folder / "search" / "decisions.jsonl")
    assert (first["id"], first["limits"]) == (answer["id"], {})
    assert (last["kind"], last["result"], last["id"]) == ("end", "cancelled", answer["id"])


def test_what_was_not_found_tells_what_was_searched(bench: Bench, monkeypatch: pytest.MonkeyPatch):
    id = bench.ask()["id"]
    bench.frames(3)
    acts(monkeypatch, SearchState.NOT_FOUND)
    bench.frames()
    told = bench.result(id)
    assert (told["result"], told["code"]) == ("not_found", 4701)
    assert told["searched"]["floor_m2"] > 1.0
    assert f"{told['searched']['floor_m2']:g} m2 of floor were seen" in told["sentence"]
    assert "in_doubt" not in told
    assert bench.rests == [SearchState.NOT_FOUND]
    assert bench.models.finished == 1


def test_who_looks_closer_tells_what_is_in_doubt_as_well(
    made: Callable[..., Bench], monkeypatch: pytest.MonkeyPatch
):
    bench = made('research.last_looks="closer"')
    id = bench.ask()["id"]
    bench.frames(3)
    acts(monkeypatch, SearchState.NOT_FOUND)
    bench.frames()
    told = bench.result(id)
    assert told["in_doubt"] == []  # in three frames nothing was seen that holds much


def test_of_no_goal_there_is_no_result_and_nothing_to_cancel_or_pause(bench: Bench):
    for kind in ("cancel", "pause", "resume", "result"):
        for id in ({}, {"id": "a1"}, {"id": 3}, {"id": "x" * 100}, {"id": ["a"]}):
            answer, _ = bench.request(kind, **id)
            assert answer is not None
            assert "error" in answer


@pytest.mark.parametrize("body", [{"goal": ""}, {"goal": 3}, {"goal": "bed", "limits": {"m": 3}}])
def test_a_refused_goal_has_a_code_and_takes_nothing_from_the_one_under_way(
    bench: Bench, body: dict[str, Any]
):
    bench.ask("bed")
    refused = bench.life.accept(body)
    assert (refused["accepted"], refused["code"]) == (False, 4720)
    assert under_way(bench) == "bed"


# -- several ---------------------------------------------------------------------------------------


def test_a_newer_goal_takes_the_place_of_all_before_it(bench: Bench):
    ids = [bench.ask("bed")["id"], bench.ask("sofa", if_busy="queue")["id"]]
    bench.ask("toilet")
    assert (under_way(bench), queue(bench)) == ("toilet", [])
    for id in ids:
        told = bench.result(id)
        assert (told["result"], told["code"]) == ("preempted", 4704)
    assert bench.models.finished == 0  # what its cloud has cost goes on to count


def test_what_a_goal_has_cost_is_its_own_to_the_end(bench: Bench, monkeypatch: pytest.MonkeyPatch):
    def health() -> dict[str, Any]:
        return {"cloud": {"goal_usd": 0.25 if bench.models.asked == ["bed"] else 0.0}}

    monkeypatch.setattr(bench.models, "health", health)
    id = bench.ask("bed")["id"]
    bench.ask("toilet")
    assert (bench.result(id)["result"], bench.result(id)["usd"]) == ("preempted", 0.25)
    bench.frames(12)
    assert bench.feedback[-1]["usd"] == 0.0


def test_a_goal_may_wait_for_its_turn(bench: Bench, monkeypatch: pytest.MonkeyPatch):
    bench.ask("bed")
    answer = bench.ask("sofa", if_busy="queue")
    assert (answer["queued"], answer["how"], answer["log_dir"]) == (1, "as it is", None)
    assert bench.ask("mug", if_busy="queue")["queued"] == 2
    assert (under_way(bench), queue(bench)) == ("bed", ["sofa", "mug"])
    bench.life.next()
    assert under_way(bench) == "bed"
    now, asked = bench.request("result", id=answer["id"])
    acts(monkeypatch, SearchState.FOUND)
    bench.frames()
    bench.life.next()
    assert (under_way(bench), queue(bench)) == ("sofa", ["mug"])
    assert (now, asked.answers) == (None, [])
    bench.frames()
    assert asked.answers[0]["result"] == "found"


def test_a_goal_that_is_not_to_preempt_is_refused_while_another_is_under_way(bench: Bench):
    assert bench.ask("bed", if_busy="refuse")["accepted"]
    refused = bench.ask("sofa", if_busy="refuse")
    assert (refused["accepted"], refused["code"]) == (False, 4721)
    assert under_way(bench) == "bed"


def test_no_more_wait_than_there_is_room_for(bench: Bench):
    bench.ask("bed")
    for _ in range(WAITING):
        assert bench.ask("sofa", if_busy="queue")["accepted"]
    refused = bench.ask("mug", if_busy="queue")
    assert refused["code"] == 4722
    told = f"goals that wait: {WAITING} now, {WAITING + 1} with this, {WAITING} at most: ask again "
    assert refused["error"].startswith(told)
    assert len(queue(bench)) == WAITING


def test_who_asks_may_have_fewer_wait(bench: Bench):
    assert bench.ask(["bed", "sofa", "mug"], queue_most=1)["code"] == 4722
    assert under_way(bench) is None
    assert bench.ask(["bed", "sofa"], queue_most=1)["accepted"]
    assert bench.ask("mug", if_busy="queue", queue_most=1)["code"] == 4722
    assert bench.ask("mug", if_busy="queue", queue_most=2)["accepted"]
    assert queue(bench) == ["sofa", "mug"]
    assert bench.ask("cup", queue_most=0)["accepted"]  # in their place
    assert (under_way(bench), queue(bench)) == ("cup", [])


def test_one_that_waits_is_understood_before_it_is_taken(bench: Bench):
    bench.ask("bed")
    assert bench.ask("mug and cup", if_busy="queue")["code"] == 4720
    assert queue(bench) == []


@pytest.mark.parametrize(
    ("goal", "several"),
    [
        ("find a mug, then a chair", "refuse"), (["find a mug", "a chair"], "refuse"),
        ("find a mug and a chair", "in_turn"),
    ],
)  # fmt: skip
def test_things_are_looked_for_one_after_the_other(
    bench: Bench, monkeypatch: pytest.MonkeyPatch, goal: object, several: str
):
    log = bench.folder / "log"
    answer = bench.ask(goal, several=several, log_dir=str(log))
    (then,) = answer["then"]
    assert (answer["name"], then["name"]) == ("find a mug", "a chair")
    assert (under_way(bench), queue(bench)) == ("find a mug", ["a chair"])
    acts(monkeypatch, SearchState.NOT_FOUND)
    bench.frames()
    bench.life.next()
    assert under_way(bench) == "a chair"
    bench.frames()
    assert bench.result(then["id"])["result"] == "not_found"
    assert (log / "decisions.jsonl").exists()
    assert log.with_name("log-2").exists()  # no search's journal is written over


def test_two_things_are_refused_where_one_was_to_be_asked_for(bench: Bench):
    refused = bench.ask(["bed", "mug and cup"])
    assert (refused["accepted"], under_way(bench)) == (False, None)


def test_a_cancel_by_name_takes_no_other_along_and_one_without_takes_all(bench: Bench):
    first = bench.ask("bed")
    second = bench.ask("sofa", if_busy="queue")
    third = bench.ask("mug", if_busy="queue")
    answer, _ = bench.request("cancel", id=second["id"])
    assert answer == {"ended": True, "cancelled": [second["id"]]}
    assert (under_way(bench), queue(bench)) == ("bed", ["mug"])
    answer, _ = bench.request("cancel", id=first["id"])
    assert answer is not None
    assert answer["id"] == first["id"]
    bench.life.next()
    assert under_way(bench) == "mug"
    bench.ask("cup", if_busy="queue")
    answer, _ = bench.request("cancel")
    assert answer is not None
    assert answer["id"] == third["id"]
    assert (under_way(bench), queue(bench)) == (None, [])
    again, _ = bench.request("cancel")  # of which nothing comes
    assert again == {**answer, "ended": False}
    assert {bench.result(goal["id"])["result"] for goal in (first, second, third)} == {"cancelled"}


def test_one_that_cannot_be_begun_when_its_turn_comes_fails_and_the_next_is_begun(
    bench: Bench, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
):
    bench.ask("bed")
    ids = [bench.ask(text, if_busy="queue")["id"] for text in ("lost", "mistaken", "sofa")]
    accept = bench.models.accept

    def refusing(goal: str, config: Any) -> Any:
        if goal == "lost":
            raise ConfigError("goal: 'lost' is no word any more")
        if goal == "mistaken":
            raise KeyError(goal)
        return accept(goal, config)

    monkeypatch.setattr(bench.models, "accept", refusing)
    first = under_way(bench)
    bench.request("cancel", id=bench.life.told()["id"])
    bench.life.next()
    assert (first, under_way(bench)) == ("bed", "sofa")
    told = [bench.result(id) for id in ids[:2]]
    assert [(t["result"], t["cause"], t["code"]) for t in told] == [("failed", "fault", 4712)] * 2
    assert told[0]["reason"] == "goal: 'lost' is no word any more"
    assert "Traceback" in capsys.readouterr().err
    assert bench.feedback[-1]["id"] == ids[1]


def test_how_a_goal_stands_is_told_to_who_does_not_wait(bench: Bench):
    first, second = bench.ask("bed")["id"], bench.ask("sofa", if_busy="queue")["id"]
    bench.frames(2)
    now, _ = bench.request("result", id=first, wait=False)
    assert now is not None
    assert (now["result"], now["ahead"], now["feedback"]["goal"]) == (None, 0, "bed")
    now, _ = bench.request("result", id=second, wait=False)
    assert now == {"id": second, "result": None, "ahead": 1, "feedback": {}}
    bench.request("cancel")
    assert bench.request("result", id=second, wait=False)[0] == bench.result(second)


# -- limits, pauses --------------------------------------------------------------------------------


def test_a_limit_of_time_ends_a_search_and_counts_no_hand_and_no_pause(bench: Bench):
    id = bench.ask(limits={"time_s": 3.0})["id"]
    bench.frames(11)  # its first frame, and a second
    bench.base = replace(bench.base, hand="sticks")
    bench.frames(20)
    bench.base = replace(bench.base, hand="")
    bench.frames(5)
    answer, _ = bench.request("pause")
    assert answer == {"paused": True, "id": id}
    bench.frames(50)
    assert bench.life.drive is not None
    assert bench.life.drive.over(bench.clock.now_s() + 60.0) is None  # also where none come
    answer, _ = bench.request("resume", id=id)
    assert answer == {"paused": False, "id": id}
    bench.frames(13)
    assert bench.life.drive is not None
    bench.frames(4)
    told = bench.result(id)
    assert (told["result"], told["code"]) == ("timed_out", 4705)
    assert told["sentence"].startswith('"toilet" ran out of time; ')


def test_a_pause_is_no_time_of_a_search_whether_or_not_frames_come(bench: Bench):
    bench.ask(limits={"time_s": 3.0})
    bench.frames(11)  # its first frame, and a second
    drive = bench.life.drive
    assert drive is not None
    for seen in (0, 1):  # while it is paused
        bench.request("pause")
        bench.frames(seen)
        bench.clock.advance(30.0)
        bench.request("pause")
        bench.frames(seen)
        bench.clock.advance(30.0)
        bench.request("resume")
        assert drive.over(bench.clock.now_s()) is None
    assert drive.over(bench.clock.now_s() + 1.8) is None
    assert drive.elapsed_s() == pytest.approx(1.1, abs=0.15)
    assert drive.over(bench.clock.now_s() + 2.1) is not None  # also where none come any more


def test_a_limit_of_time_holds_without_a_single_frame(bench: Bench):
    bench.ask(limits={"time_s": 3.0})
    assert bench.life.drive is not None
    assert bench.life.drive.over(102.9) is None
    end = bench.life.drive.over(103.0)
    assert end is not None
    assert end.state is SearchState.TIMED_OUT


def test_a_limit_of_distance_ends_a_search(bench: Bench):
    id = bench.ask(limits={"distance_m": 0.5})["id"]
    for x in (4.0, 4.2, 4.4, 4.6):
        bench.stand(x, 3.0)
        bench.frames()
    assert bench.life.drive is None or under_way(bench)
    bench.frames()
    told = bench.result(id)
    assert (told["result"], told["cause"], told["code"]) == ("failed", "distance", 4711)
    assert told["driven_m"] == pytest.approx(0.6)


def test_a_limit_of_money_is_the_models_to_keep(bench: Bench):
    bench.ask(limits={"money_usd": 0.01})
    bench.ask()
    assert bench.models.afforded == [0.01, None]


def test_a_paused_robot_stands_and_looks_and_decides_nothing(bench: Bench):
    bench.ask()
    bench.frames(3)
    steps = bench.life.drive.search.world.body.step  # type: ignore[union-attr]
    bench.request("pause")
    assert bench.plans[-1].course is None
    assert bench.plans[-1].report["paused"] == f"paused by {ASKED_ON}"
    assert bench.feedback[-1]["paused"] == ASKED_ON
    bench.frames(3)
    drive = bench.life.drive
    assert drive is not None
    assert drive.search.world is not None
    assert drive.search.world.body.step == steps
    assert (bench.mode, bench.plans[-1].course) == ("pause", None)
    assert bench.life.told()["paused"] == ASKED_ON
    bench.request("resume")
    bench.frames()
    assert drive.search.world.body.step == steps + 1
    assert "paused" not in bench.plans[-1].report
    kinds = [line["kind"] for line in read_journal(bench.folder / "search" / "decisions.jsonl")]
    assert kinds.count("paused") == 2  # taken, and given back


def test_a_newer_goal_is_not_paused(bench: Bench):
    id = bench.ask()["id"]
    bench.request("pause")
    bench.ask("bed")
    assert bench.life.told()["paused"] == ""
    assert bench.request("resume", id=id)[0] == {
        "paused": False, "error": f"no goal {id!r} is known"
    }  # fmt: skip


# -- afterwards, battery ---------------------------------------------------------------------------


def test_a_robot_goes_back_before_it_says_what_it_found(
    bench: Bench, monkeypatch: pytest.MonkeyPatch
):
    id = bench.ask(afterwards="return")["id"]
    bench.frames(12)
    bench.stand(5.0, 3.0)
    bench.frames()
    acts(monkeypatch, SearchState.FOUND, "found toilet 1")
    bench.frames()
    assert bench.life.drive is not None
    bench.frames(3)
    assert bench.mode == "return"
    bench.stand(4.1, 3.0)
    bench.frames()
    told = bench.result(id)
    assert (told["result"], told["returned"], told["at_xy"]) == ("found", True, [4.5, 3.0])
    assert told["reason"] == "found toilet 1; it is back where it began"
    assert told["sentence"].startswith('"toilet" was found at (4.5, 3.0); it took ')
    assert told["sentence"].endswith("; the robot is back where it began")
    assert bench.rests == [SearchState.FOUND]


class Places(NoZones):
    """One place, and an area round where the robot begins."""

    def bounds(self, body: Mapping[str, Any], rooms: Sequence[str]) -> GoalBounds:
        dock = Destination("dock", (5.0, 3.0))
        if "go_to" in body:
            return GoalBounds(to=dock)
        then = body.get("afterwards")
        if then is not None and then["place"] != "dock":
            raise ConfigError("nobody has named it")
        then_to = dock if then is not None else None
        if "area" in body:
            square = ((-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0))
            corners = tuple((4.0 + x, 3.0 + y) for x, y in square)
            return GoalBounds(area=Zone(AREA, corners, area=True), then_to=then_to)
        return replace(ANYWHERE, then_to=then_to)


@pytest.mark.parametrize("if_busy", ["preempt", "queue"])
def test_a_goal_that_is_to_end_nowhere_is_refused_before_the_models_hear_of_it(
    made: Callable[..., Bench], if_busy: str
):
    bench = made(zones=Places())
    bench.ask("bed")
    refused = bench.ask("sofa", afterwards={"place": "docks"}, if_busy=if_busy)
    assert (refused["code"], refused["error"]) == (4720, "nobody has named it")
    assert (bench.models.asked, under_way(bench)) == (["bed"], "bed")  # and is looked for


@pytest.mark.parametrize("area", [False, True])
def test_a_robot_goes_to_a_place_before_it_says_what_it_found_and_out_of_its_area_for_it(
    made: Callable[..., Bench], monkeypatch: pytest.MonkeyPatch, area: bool
):
    bench = made(zones=Places())
    binds = {"area": {"place": "sofa"}} if area else {}
    id = bench.ask(afterwards={"place": "dock"}, **binds)["id"]
    bench.frames(12)
    drive = bench.life.drive
    assert drive is not None
    assert drive.way.ends(GoalEnd(SearchState.FOUND, "found toilet 1")) is None
    assert drive.search.whereabouts.bounds.area is None
    bench.stand(4.9, 3.0)
    bench.frames(3)
    told = bench.result(id)
    assert (told["result"], told["returned"]) == ("found", True)
    assert told["reason"] == "found toilet 1; arrived at dock"
    assert told["sentence"].endswith("; the robot is at dock")


def test_a_robot_that_goes_back_within_its_area_is_kept_in_it(made: Callable[..., Bench]):
    bench = made(zones=Places())
    bench.ask(afterwards="return", area={"place": "sofa"})
    bench.frames(2)
    drive = bench.life.drive
    assert drive is not None
    assert drive.way.ends(GoalEnd(SearchState.FOUND, "found toilet 1")) is None
    assert drive.search.whereabouts.bounds.area is not None


@pytest.mark.parametrize(
    "end",
    [
        GoalEnd(SearchState.AREA_LEFT, "it is outside"),
        GoalEnd(SearchState.FAILED, "where are the zones?", FailCause.NOT_LOCALISED),
    ],
)
def test_who_is_not_where_it_was_to_be_goes_nowhere_by_itself(bench: Bench, end: GoalEnd):
    bench.ask(afterwards="return")
    bench.frames(2)
    drive = bench.life.drive
    assert drive is not None
    assert drive.way.ends(end) is end


def test_a_search_that_is_cancelled_does_not_go_back(bench: Bench):
    id = bench.ask(afterwards="return")["id"]
    bench.frames(2)
    bench.request("cancel")
    assert "returned" not in bench.result(id)


@pytest.mark.parametrize(("when_low", "afterwards"), [("end", "return"), ("return", "stay")])
def test_a_low_battery_is_what_a_goal_fails_of_as_the_robot_is_configured(
    made: Callable[..., Bench], when_low: str, afterwards: str
):
    bench = made(f"battery.when_low={when_low}")
    id = bench.ask(afterwards=afterwards)["id"]
    bench.frames(2)
    bench.base = replace(bench.base, battery_percent=3.0)
    bench.frames(60)
    told = bench.result(id)
    assert (told["result"], told["cause"], told["code"]) == ("failed", "battery", 4710)
    assert told.get("returned") == (True if when_low == "return" else None)
    assert bench.rests == [SearchState.FAILED]
    refused = bench.ask()
    assert (refused["accepted"], refused["code"]) == (False, 4723)


def test_a_goal_that_waited_is_not_begun_with_a_battery_that_is_too_low(
    made: Callable[..., Bench],
):
    bench = made("battery.when_low=refuse")
    bench.base = replace(bench.base, battery_percent=80.0)
    bench.ask("bed")
    id = bench.ask("sofa", if_busy="queue")["id"]
    bench.frames(2)
    bench.base = replace(bench.base, battery_percent=3.0)
    bench.frames(60)
    assert under_way(bench) == "bed"  # as its owner wishes
    bench.request("cancel", id=bench.life.told()["id"])
    bench.life.next()
    told = bench.result(str(id))
    assert (under_way(bench), told["cause"], told["code"]) == (None, "battery", 4710)


# -- restarts --------------------------------------------------------------------------------------


def test_goals_go_on_after_a_restart_under_their_names(
    made: Callable[..., Bench], monkeypatch: pytest.MonkeyPatch
):
    bench = made(after_restart="resume")
    ids = [bench.ask("bed")["id"], bench.ask("sofa", if_busy="queue")["id"]]
    bench.frames(2)
    now, asked = bench.request("result", id=ids[0])
    bench.life.close(ENDS)  # in order; a crash leaves no more
    assert bench.rests == [SearchState.ENDED]
    assert (now, asked.answers[0]["error"][:10]) == (None, "rfnav ends")
    bench.again()
    bench.life.next()
    assert (under_way(bench), queue(bench)) == ("bed", ["sofa"])
    assert bench.life.told()["id"] == ids[0]
    acts(monkeypatch, SearchState.FOUND)
    for _ in ids:
        bench.frames()
        bench.life.next()
    assert [bench.result(id)["result"] for id in ids] == ["found", "found"]
    bench.again()
    bench.life.next()
    assert under_way(bench) is None


def test_a_goal_that_the_runtime_always_ends_with_is_not_begun_for_ever(made: Callable[..., Bench]):
    bench = made(after_restart="resume")
    id = bench.ask("bed")["id"]
    for _ in range(TRIES - 1):
        bench.again()  # without an end: it crashed
        bench.life.next()
        assert under_way(bench) == "bed"
    bench.again()
    bench.life.next()
    assert under_way(bench) is None
    told = bench.result(id)
    assert (told["result"], told["cause"], told["code"]) == ("failed", "restart", 4713)
    assert told["reason"] == f"{TRIES} searches for it ended with the runtime"


def test_a_place_that_was_told_in_metres_is_not_gone_to_in_another_odometry(
    made: Callable[..., Bench],
):
    bench = made(after_restart="resume", zones=Places())
    ids = [bench.life.accept({"go_to": "dock"})["id"]]
    ids += [bench.life.accept({"go_to": {"x_m": 5.0, "y_m": 3.0}, "if_busy": "queue"})["id"]]
    bench.again()
    bench.life.next()
    assert (bench.life.told()["id"], queue(bench)) == (ids[0], [])
    told = bench.result(str(ids[1]))
    assert (told["cause"], told["code"]) == ("restart", 4713)
    assert "metres" in told["reason"]


def test_a_robot_that_was_paused_does_not_drive_off_after_a_restart(made: Callable[..., Bench]):
    bench = made(after_restart="resume")
    bench.ask("bed")
    bench.request("pause")
    bench.again()
    bench.life.next()
    assert bench.life.told()["paused"] == ASKED_ON
    bench.request("resume")
    bench.again()
    bench.life.next()
    assert (under_way(bench), bench.life.told()["paused"]) == ("bed", "")


@pytest.mark.parametrize("in_order", [True, False])
def test_goals_that_are_not_to_go_on_are_reported_as_failed_once(
    made: Callable[..., Bench], in_order: bool
):
    bench = made(after_restart="fail")
    ids = [bench.ask("bed")["id"], bench.ask("sofa", if_busy="queue")["id"]]
    if in_order:  # then at once, to whoever still listens
        bench.life.close(ENDS)
    else:
        bench.again()
        bench.life.next()
        assert under_way(bench) is None
    for id in ids:
        told = bench.result(id)
        assert (told["result"], told["cause"], told["code"]) == ("failed", "restart", 4713)
    assert {told["id"] for told in bench.feedback if told.get("result")} == set(ids)
    told_before = len(bench.feedback)
    bench.again()
    assert len(bench.feedback) == told_before


def test_a_file_of_goals_that_is_none_is_put_aside_and_said(
    made: Callable[..., Bench], capsys: pytest.CaptureFixture[str]
):
    bench = made(after_restart="resume")
    (bench.folder / FILE).write_text("{")
    bench.again()
    bench.life.next()
    assert under_way(bench) is None
    assert "goals.json.aside-1" in capsys.readouterr().err
    assert bench.ask()["accepted"]


class Lost(NoZones):
    """Zones are drawn on a saved map, and nobody knows where that lies."""

    where = ""

    def unbound(self) -> str:
        return self.where


@pytest.mark.parametrize("to", ["return", {"place": "dock"}])
def test_on_its_way_back_a_robot_stops_where_nobody_knows_any_more_where_zones_lie(
    made: Callable[..., Bench], monkeypatch: pytest.MonkeyPatch, to: object
):
    zones = Places()
    bench = made(zones=zones)
    id = bench.ask(afterwards=to)["id"]
    bench.frames(12)
    bench.stand(4.5, 3.0)
    acts(monkeypatch, SearchState.FOUND, "found toilet 1")
    bench.frames(2)
    assert bench.life.drive is not None
    monkeypatch.setattr(zones, "unbound", lambda: "odometry has jumped")
    bench.frames()
    told = bench.result(id)
    assert (told["result"], told["returned"]) == ("found", False)
    assert told["reason"] == "found toilet 1; odometry has jumped"


def test_while_nobody_knows_where_the_robot_is_no_goal_is_taken_and_none_begun(
    made: Callable[..., Bench], monkeypatch: pytest.MonkeyPatch
):
    lost = Lost()
    bench = made(after_restart="resume", zones=lost)
    bench.ask("bed")
    bench.again()
    lost.where = "zones: nobody knows where they lie"
    refused = bench.ask()
    assert (refused["code"], refused["error"]) == (4724, lost.where)
    assert bench.life.told()["refuses"] == lost.where
    bench.life.next()
    assert (under_way(bench), queue(bench)) == (None, ["bed"])
    lost.where = ""
    bench.life.next()
    assert under_way(bench) == "bed"
