"""What else is asked of the running service."""

import json
from collections.abc import Callable, Iterator
from contextlib import nullcontext
from types import SimpleNamespace
from typing import Any

import pytest
from click.testing import CliRunner, Result

from hil_sim.driving.link import free_port
from runtime.__main__ import cli
from runtime.commands import goal_control
from runtime.robot.requests import QUERIES
from runtime.robot.session import BusConfig, open_session
from runtime.service.limits import MOST

Ask = Callable[..., Result]


@pytest.fixture
def answered() -> Iterator[tuple[Ask, list[tuple[str, dict[str, Any]]], dict[str, Any]]]:
    """Runs a command; what was asked, and what is answered."""
    end, heard = f"tcp/127.0.0.1:{free_port()}", []
    answer: dict[str, Any] = {}
    with open_session(BusConfig(listen=(end,))) as session:

        def reply(query) -> None:
            kind = str(query.key_expr).removeprefix("rfnav/")
            heard.append((kind, json.loads(query.payload.to_string())))
            query.reply(query.key_expr, json.dumps(answer))

        for kind in ("cancel", "pause", "resume", "stop", "zones"):
            session.declare_queryable(f"rfnav/{kind}", reply)

        def ask(*words: str) -> Result:
            return CliRunner().invoke(cli, [*words, "--set", f"bus.listen=['{end}']"])

        yield ask, heard, answer


@pytest.mark.parametrize(
    ("words", "kind", "body", "answer", "said"),
    [
        (("cancel",), "cancel", {"reason": "rfnav cancel"},
         {"ended": True, "sentence": "it was cancelled"},
         "it was cancelled"),
        (("cancel", "a1"), "cancel", {"reason": "rfnav cancel", "id": "a1"},
         {"ended": True, "cancelled": ["a1"]}, "cancelled: a1"),
        (("pause",), "pause", {}, {"paused": True, "id": "a1"}, "a1: paused"),
        (("resume",), "resume", {}, {"paused": False, "id": "a1"}, "a1: goes on"),
        (("ask", "stop"), "stop", {}, {"stopped": True}, '{"stopped": true}'),
        (("ask", "rfnav/zones", '{"list": true}'), "zones", {"list": True}, {"zones": []},
         '{"zones": []}'),
    ],
)  # fmt: skip
def test_what_is_answered_is_said(answered, words, kind, body, answer, said):
    ask, heard, answers = answered
    answers.update(answer)
    done = ask(*words)
    assert (done.output, done.exit_code) == (f"{said}\n", 0)
    assert heard == [(kind, body)]


@pytest.mark.parametrize("words", [("cancel",), ("pause",), ("resume",)])
def test_where_nothing_is_under_way_that_is_said(answered, words):
    ask, _, answers = answered
    answers.update(error="no search is under way")
    done = ask(*words)
    assert (done.stderr, done.exit_code) == ("rfnav: no search is under way\n", 1)


def test_a_result_is_waited_for_as_long_as_a_goal_may_take(monkeypatch: pytest.MonkeyPatch):
    waited: dict[str, float] = {}

    def ask(kind: str, body: object, within_s: float) -> dict[str, Any]:
        waited[kind] = within_s
        return {}

    runtime = nullcontext(SimpleNamespace(ask=ask))
    monkeypatch.setattr(goal_control, "running", lambda config: runtime)
    for kind in ("status", "result"):
        CliRunner().invoke(cli, ["ask", kind])
    assert waited == {"status": goal_control.ANSWERED_S, "result": MOST["time_s"]}


def test_what_came_of_an_earlier_goal_is_no_cancel(answered):
    ask, _, answers = answered
    answers.update(ended=False, sentence="it was found")
    done = ask("cancel")
    assert (done.stdout, done.stderr) == ("", "rfnav: nothing is under way\n")
    assert done.exit_code == 1


def test_all_kinds_that_are_answered_are_told(answered):
    ask, _, _ = answered
    told = " ".join(ask("ask", "--help").output.split())
    assert all(f" {kind}" in told for kind in QUERIES)


def test_a_refusal_is_printed_and_is_a_failure(answered):
    ask, _, answers = answered
    answers.update(accepted=False, error="busy")
    done = ask("ask", "stop")
    assert (json.loads(done.output)["error"], done.exit_code) == ("busy", 1)


def test_what_is_no_json_is_not_sent(answered):
    ask, heard, _ = answered
    done = ask("ask", "stop", "{")
    assert (heard, done.exit_code) == ([], 2)
    assert "REQUEST: not JSON" in done.stderr


def test_what_is_answered_is_told_to_programs(answered):
    ask, _, answers = answered
    answers.update(ended=True, sentence="it was cancelled")
    done = ask("cancel", "--json")
    assert (done.exit_code, json.loads(done.stdout)) == (0, answers)
    answers.clear()
    answers.update(error="no search is under way", paused=False)
    for command in ("pause", "resume"):
        done = ask(command, "--json")
        assert (done.exit_code, json.loads(done.stdout)) == (1, answers)
