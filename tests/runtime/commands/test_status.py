"""rfnav status: what it prints, again and again where asked, and what it ends with."""

import json
import sys
from collections.abc import Callable, Iterator
from types import SimpleNamespace
from typing import Any

import pytest
from click.testing import CliRunner, Result

from hil_sim.driving.link import free_port
from runtime.__main__ import cli
from runtime.commands import status as module
from runtime.errors import BusError
from runtime.robot.session import BusConfig, open_session

Ask = Callable[..., Result]


def run(*words: str) -> Result:
    return CliRunner().invoke(cli, ["status", *words])


@pytest.fixture
def answered(monkeypatch: pytest.MonkeyPatch) -> Iterator[tuple[Ask, dict[str, Any]]]:
    """Asks a runtime; what that answers."""
    end = f"tcp/127.0.0.1:{free_port()}"
    answer: dict[str, Any] = {"runtime": {"state": "ready", "cause": ""}, "now_s": 0.0}
    monkeypatch.setattr(module, "BETWEEN_S", 0.0)
    with open_session(BusConfig(listen=(end,))) as session:

        def reply(query) -> None:
            answer["now_s"] += 1.0
            query.reply(query.key_expr, json.dumps(answer))

        session.declare_queryable("rfnav/status", reply)
        yield (lambda *words: run(*words, "--set", f"bus.listen=['{end}']")), answer


def test_what_is_well_ends_with_0(answered: tuple[Ask, dict[str, Any]]):
    ask, answer = answered
    answer["streams"] = {"odom": {"received": 4, "bad": 0, "arrival_s": 1.5}}
    done = ask()
    assert done.exit_code == 0
    assert done.output.startswith("state    ready\ngoal     none\n")
    assert "odom                                           0.0     0.5      0" in done.output


def test_what_is_wrong_ends_with_1_and_is_said_first(answered: tuple[Ask, dict[str, Any]]):
    ask, answer = answered
    answer["runtime"] = {"state": "held", "cause": "frame: none"}
    done = ask()
    assert (done.exit_code, done.output.splitlines()[0]) == (1, "WRONG    held: frame: none")
    as_json = ask("--json")
    assert as_json.exit_code == 1
    assert json.loads(as_json.output)["wrong"] == ["held: frame: none"]
    assert json.loads(as_json.output)["runtime"]["state"] == "held"


def test_the_streams_that_a_search_needs_are_the_configurations(
    answered: tuple[Ask, dict[str, Any]],
):
    ask, answer = answered
    answer["streams"] = {"wheel_odom": {"received": 0, "arrival_s": None}}
    assert ask().exit_code == 0
    done = ask("--set", "bus.topics.odom=wheel_odom")
    assert (done.exit_code, done.output.splitlines()[0]) == (
        1, "WRONG    wheel_odom: nothing has come",
    )  # fmt: skip
    assert ask("--set", "bus.topics.pose=wheel_odom").exit_code == 1


class Nights:
    """Sleeps so often, then somebody presses Ctrl-C."""

    def __init__(self, left: int) -> None:
        self.left = left

    def __call__(self, seconds: float) -> None:
        self.left -= 1
        if self.left < 0:
            raise KeyboardInterrupt


def test_watching_goes_on_until_ctrl_c(
    answered: tuple[Ask, dict[str, Any]], monkeypatch: pytest.MonkeyPatch
):
    ask, _ = answered
    monkeypatch.setattr(module.time, "sleep", Nights(2))
    done = ask("--watch")
    assert (done.exit_code, done.output.count("state    ready")) == (0, 3)
    assert "\x1b" not in done.output  # it is no terminal
    monkeypatch.setattr(module.time, "sleep", Nights(1))
    lines = ask("--watch", "--json").output.splitlines()
    assert [json.loads(line)["wrong"] for line in lines] == [[], []]


@pytest.mark.parametrize(
    ("term", "as_json", "drawn"), [("xterm", (), 1), ("dumb", (), 0), ("xterm", ("--json",), 0)]
)
def test_it_is_drawn_where_a_terminal_can(
    term: str,
    as_json: tuple[str, ...],
    drawn: int,
    answered: tuple[Ask, dict[str, Any]],
    monkeypatch: pytest.MonkeyPatch,
):
    class Terminal:
        def isatty(self) -> bool:
            return True

    ask, _ = answered
    monkeypatch.setenv("TERM", term)
    monkeypatch.setattr(module, "sys", SimpleNamespace(stdout=Terminal(), exit=sys.exit))
    monkeypatch.setattr(module.time, "sleep", Nights(0))
    assert ask("--watch", *as_json).output.count("\x1b[H") == drawn


def test_on_a_terminal_it_is_drawn_in_place(monkeypatch: pytest.MonkeyPatch):
    size = (20, 3)
    monkeypatch.setattr(module.shutil, "get_terminal_size", lambda: size)
    drawn = module._drawn(["one", "two" * 20, "three", "four"])
    assert drawn == "\x1b[Hone\x1b[K\n" + ("two" * 20)[:20] + "\x1b[K\n\x1b[J"


def test_a_service_that_goes_away_is_waited_for(
    answered: tuple[Ask, dict[str, Any]], monkeypatch: pytest.MonkeyPatch
):
    ask, _ = answered
    asked = module.Running.ask

    def away(self: object, *_: object) -> dict[str, Any]:
        raise BusError("nobody answers")

    def sleep(seconds: float) -> None:
        nights(seconds)
        monkeypatch.setattr(module.Running, "ask", away if nights.left == 1 else asked)

    nights = Nights(2)
    monkeypatch.setattr(module.time, "sleep", sleep)
    done = ask("--watch")
    assert done.output.count("state    ready") == 2
    assert done.output.count("rfnav: nobody answers\n") == 1


def test_where_nobody_is_there_that_is_an_error():
    done = run("--set", f"bus.listen=['tcp/127.0.0.1:{free_port()}']")
    assert isinstance(done.exception, BusError)  # which ends with 2
    assert "nobody listens: is rfnav run up?" in str(done.exception)
