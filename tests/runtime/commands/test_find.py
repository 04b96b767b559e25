"""rfnav find: what it asks, prints and ends with."""

import io
import json
from collections.abc import Callable, Iterator
from typing import Any

import pytest
from click.testing import CliRunner, Result

from hil_sim.driving.link import free_port
from runtime.__main__ import cli
from runtime.commands import find, running
from runtime.commands.find import STOPPED, SoFar
from runtime.robot.session import BusConfig, open_session

TAKEN = {"accepted": True, "id": "a1", "name": "mug", "how": "a mug: mug, of the list", "queued": 0}
FEEDBACK = {
    "state": "searching", "reason": "drive to frontier 3", "elapsed_s": 12.3, "driven_m": 4.56,
    "frontiers": 5, "usd": 0.0,
}  # fmt: skip
UNDER_WAY = {"id": "a1", "result": None, "ahead": 0, "feedback": FEEDBACK}
FOUND = {"id": "a1", "result": "found", "code": 0, "sentence": "a mug was found"}


class Service:
    """`answers`: by kind, one after the other, None for one that never comes; the last of them is
    given again and again."""

    def __init__(self) -> None:
        self.end = f"tcp/127.0.0.1:{free_port()}"
        self.answers: dict[str, list[dict[str, Any] | None]] = {}
        self.unanswered: list[Any] = []
        self.heard: list[tuple[str, dict[str, Any]]] = []

    def find(self, *words: str, command: str = "find") -> Result:
        return CliRunner().invoke(cli, [command, *words, "--set", f"bus.listen=['{self.end}']"])

    def asked(self, kind: str) -> list[dict[str, Any]]:
        return [body for heard, body in self.heard if heard == kind]


@pytest.fixture
def service(monkeypatch: pytest.MonkeyPatch) -> Iterator[Service]:
    monkeypatch.setattr(find, "EVERY_S", 0.0)
    made = Service()
    made.answers = {"goal": [TAKEN], "result": [UNDER_WAY, UNDER_WAY, FOUND], "cancel": [{}]}
    made.answers["status"] = [{"goal": None}]
    with open_session(BusConfig(listen=(made.end,))) as session:

        def answering(kind: str) -> Callable[[Any], None]:
            def reply(query: Any) -> None:
                made.heard.append((kind, json.loads(query.payload.to_string())))
                answers = made.answers[kind]
                answer = answers.pop(0) if len(answers) > 1 else answers[0]
                if answer is None:
                    made.unanswered.append(query)
                else:
                    query.reply(query.key_expr, json.dumps(answer))

            return reply

        for kind in made.answers:
            session.declare_queryable(f"rfnav/{kind}", answering(kind))
        yield made
        made.unanswered.clear()


def test_how_it_was_understood_how_it_goes_and_what_came_of_it(service: Service):
    done = service.find("a mug")
    assert done.stdout == "a1: a mug: mug, of the list\na mug was found\n"
    assert done.stderr == "drive to frontier 3 (12 s, 4.6 m, frontiers left: 5)\n"  # once
    assert done.exit_code == 0
    assert service.asked("goal") == [{"goal": "a mug", "limits": {}}]
    assert service.asked("result") == [{"id": "a1", "wait": False}] * 3


def test_what_is_asked_for_is_asked_on(service: Service):
    words = ["--limit-time", "60", "--limit-distance", "5", "--limit-money", "0.1", "--return"]
    more = ["--area-room", "kitchen"]
    service.find("a mug", "--then", "a chair", "--each", "--queue", *words, *more)
    assert service.asked("goal") == [
        {
            "goal": ["a mug", "a chair"],
            "limits": {"time_s": 60.0, "distance_m": 5.0, "money_usd": 0.1},
            "several": "in_turn",
            "if_busy": "queue",
            "afterwards": "return",
            "area": {"room": "kitchen"},
        }
    ]


@pytest.mark.parametrize(
    ("place", "told"),
    [
        ("kitchen table", "kitchen table"), ("table, kitchen", "table, kitchen"),
        ("1.5,-2", {"x_m": 1.5, "y_m": -2.0}), ("-1.5,2", {"x_m": -1.5, "y_m": 2.0}),
        ("1,0,3.1", {"x_m": 1.0, "y_m": 0.0, "yaw_rad": 3.1}),
    ],
)  # fmt: skip
def test_a_place_is_gone_to(service: Service, place: str, told: object):
    done = service.find(place, "--return-to", "dock", command="go")
    assert done.exit_code == 0
    expected = {"go_to": told, "limits": {}, "afterwards": {"place": "dock"}}
    assert service.asked("goal") == [expected]


def test_one_number_is_no_place(service: Service):
    assert service.find("1.5", command="go").exit_code != 0
    assert service.asked("goal") == []


def test_each_of_several_is_waited_for_and_one_that_was_not_found_is_told(service: Service):
    service.answers["goal"] = [TAKEN | {"then": [{"id": "b2", "name": "chair", "how": "a chair"}]}]
    lost = {"id": "b2", "result": "not_found", "code": 4701, "sentence": "a chair was not found"}
    waits = {"id": "b2", "result": None, "ahead": 1, "feedback": {}}
    service.answers["result"] = [FOUND, waits, lost]
    done = service.find("a mug, then a chair")
    assert done.exit_code == 1
    assert done.stdout.splitlines()[1:] == ["b2: a chair", "a mug was found", lost["sentence"]]
    assert done.stderr == "b2: waits for 1 before it\n"
    assert [body["id"] for body in service.asked("result")] == ["a1", "b2", "b2"]


def test_a_goal_that_is_not_taken_is_an_error(service: Service):
    service.answers["goal"] = [{"accepted": False, "code": 4720, "error": "goal: is a place"}]
    done = service.find("the kitchen")
    assert (done.exit_code, done.stdout, done.stderr) == (2, "", "rfnav: goal: is a place\n")
    told = service.find("the kitchen", "--json")
    assert (told.exit_code, json.loads(told.stdout)["code"]) == (2, 4720)


def test_as_json_and_without_waiting(service: Service):
    done = service.find("a mug", "--json")
    assert (done.stderr, done.exit_code) == ("", 0)
    assert json.loads(done.stdout) == TAKEN | {"results": [FOUND]}
    before = len(service.asked("result"))
    assert service.find("a mug", "--no-wait").stdout == "a1: a mug: mug, of the list\n"
    assert json.loads(service.find("a mug", "--no-wait", "--json").stdout) == TAKEN
    assert len(service.asked("result")) == before


def test_ctrl_c_cancels_what_was_asked_for_the_last_first(
    service: Service, monkeypatch: pytest.MonkeyPatch
):
    service.answers["goal"] = [TAKEN | {"then": [{"id": "b2", "name": "chair", "how": "a chair"}]}]
    service.answers["result"] = [UNDER_WAY]

    def interrupted(seconds: float) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(find.time, "sleep", interrupted)
    done = service.find("a mug, then a chair")
    assert done.exit_code == 130
    assert service.asked("cancel") == [{"id": id, "reason": STOPPED} for id in ("b2", "a1")]
    assert done.stderr.endswith("b2: cancelled\na1: cancelled\n")


def test_a_service_whose_models_load_is_asked_for_nothing_until_it_answers(
    service: Service, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setattr(running, "ANSWER_S", 0.05)
    full = {"accepted": False, "error": "busy: 16 status requests wait already"}
    service.answers["status"] = [None, None, full, {"goal": None}]
    done = service.find("a mug", "--no-wait")
    assert (done.exit_code, done.stderr) == (0, f"{find.SILENT}\n")
    assert [kind for kind, _ in service.heard] == [*["status"] * 4, "goal"]


@pytest.mark.parametrize(
    ("answer", "why"),
    [(None, "rfnav run is there, and has not answered on rfnav/status"),
     ({"accepted": False, "error": "busy: 16 wait"}, "busy: 16 wait")],
)  # fmt: skip
def test_one_that_never_answers_is_not_waited_for_for_ever(
    service: Service, monkeypatch: pytest.MonkeyPatch, answer: dict[str, Any] | None, why: str
):
    monkeypatch.setattr(running, "ANSWER_S", 0.05)
    monkeypatch.setattr(find, "LOADED_S", 0.0)
    service.answers["status"] = [answer]
    done = service.find("a mug")
    assert why in str(done.exception)
    assert service.asked("goal") == []


def test_a_goal_that_is_not_answered_in_time_may_be_taken_yet(
    service: Service, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setattr(find, "TAKEN_S", 0.05)
    service.answers["goal"] = [None]
    done = service.find("a mug")
    assert str(done.exception).endswith(f"or it is busy; {find.TAKEN_YET}")


def test_what_a_terminal_would_obey_is_not_printed(service: Service):
    service.answers["goal"] = [TAKEN | {"how": "\x1b[2Ja mug"}]
    feedback = {**UNDER_WAY, "feedback": {**FEEDBACK, "reason": "\x9b2J said a model"}}
    service.answers["result"] = [feedback, {**FOUND, "sentence": "\x07found"}]
    done = service.find("a mug")
    assert done.stdout == "a1:  [2Ja mug\n found\n"
    assert done.stderr.startswith(" 2J said a model (")


def test_ctrl_c_before_it_is_taken_says_that_it_may_be(
    service: Service, monkeypatch: pytest.MonkeyPatch
):
    asks = find.Running.ask

    def interrupted(runtime: Any, kind: str, *how: Any) -> dict[str, Any]:
        if kind == "goal":
            raise KeyboardInterrupt
        return asks(runtime, kind, *how)

    monkeypatch.setattr(find.Running, "ask", interrupted)
    done = service.find("a mug")
    assert done.exit_code == 130
    assert done.stderr == "rfnav: it may be taken yet: rfnav cancel ends all goals\n"


def test_a_service_that_has_forgotten_the_goal_is_told_of(service: Service):
    service.answers["result"] = [{"error": "no goal 'a1' is known"}]
    done = service.find("a mug")
    assert done.exit_code == 1  # an exception, for `main` to tell
    assert "no goal 'a1' is known: the service was started anew" in str(done.exception)


def test_a_service_that_is_away_is_waited_for_and_not_for_ever(
    service: Service, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setattr("runtime.commands.running.ANSWER_S", 0.01)
    monkeypatch.setattr(find, "AWAY_S", 0.05)
    service.answers["goal"] = [TAKEN]
    service.answers["result"] = [UNDER_WAY]
    asks = find.Running.ask

    def away(runtime: Any, kind: str, body: Any, within_s: float = 1.0) -> dict[str, Any]:
        if kind == "result":
            raise find.BusError("nobody answers on rfnav/result")
        return asks(runtime, kind, body, within_s)

    monkeypatch.setattr(find.Running, "ask", away)
    done = service.find("a mug")
    assert "nobody answers on rfnav/result" in str(done.exception)
    assert "nobody answers: is the service started anew?" in done.stderr


@pytest.mark.parametrize("why", ["rfnav ends", "busy: 16 result requests wait already"])
def test_a_service_that_ends_just_now_is_waited_for(
    service: Service, monkeypatch: pytest.MonkeyPatch, why: str
):
    monkeypatch.setattr(find, "EVERY_S", 0.01)
    service.answers["goal"] = [TAKEN]
    service.answers["result"] = [{"accepted": False, "error": why}, FOUND]
    done = service.find("a mug")
    assert (done.exit_code, done.stdout.splitlines()[-1]) == (0, FOUND["sentence"])


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


def test_on_a_terminal_one_line_is_drawn_anew(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setenv("COLUMNS", "30")
    out = Terminal()
    so_far = SoFar(out, quiet=False)
    so_far.show(UNDER_WAY)
    so_far.show({**UNDER_WAY, "feedback": {**FEEDBACK, "reason": "", "usd": 0.25}})
    so_far.clear()
    so_far.clear()
    assert out.getvalue() == (
        "\rdrive to frontier 3 (12 s, 4.\x1b[K\rsearching (12 s, 4.6 m, 0.250\x1b[K\r\x1b[K"
    )
