"""rfnav why: what it asks, prints and ends with."""

import json
from collections.abc import Callable, Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from click.testing import CliRunner, Result

from hil_sim.driving.link import free_port
from runtime.__main__ import cli
from runtime.core.types import Ballot, Brief
from runtime.core.voting.consensus import ConsensusConfig, elect
from runtime.journal import Journal
from runtime.loops.reports import explain
from runtime.robot.session import BusConfig, open_session

DECISION = {"number": 4, "goal": "mug", "in_words": ["Decision 4.", "  as told"]}
STOP = {"number": 2, "in_words": ["Stop 2."]}
Ask = Callable[..., Result]


@pytest.fixture
def answered(tmp_path: Path) -> Iterator[tuple[Ask, list[dict[str, Any]], dict[str, Any]]]:
    """Asks a runtime; what that was asked, and what it answers."""
    end, heard = f"tcp/127.0.0.1:{free_port()}", []
    answer: dict[str, Any] = {}
    with open_session(BusConfig(listen=(end,))) as session:

        def reply(query) -> None:
            heard.append(json.loads(query.payload.to_string()))
            query.reply(query.key_expr, json.dumps(answer))

        session.declare_queryable("rfnav/why", reply)
        status = json.dumps({"journal": str(tmp_path / "decisions.jsonl")})
        session.declare_queryable("rfnav/status", lambda query: query.reply(query.key_expr, status))
        yield (lambda *words: run(*words, "--set", f"bus.listen=['{end}']")), heard, answer


def run(*words: str) -> Result:
    return CliRunner().invoke(cli, ["why", *words])


def test_the_last_decision_and_the_last_stop(answered):
    ask, heard, answer = answered
    answer.update(now="look at mug 7", decision=DECISION, stop=STOP)
    done = ask()
    told = "Now: look at mug 7.\n\nDecision 4.\n  as told\n\nStop 2.\n"
    assert (done.output, done.exit_code) == (told, 0)
    answer.update(stop={"number": 2, "in_words": ["Stop 2\x1b[31m."]})
    assert ask("--stop").output == "Stop 2 [31m.\n"  # nothing that a terminal would obey
    assert heard == [{}, {}]


def test_one_by_its_number(answered):
    ask, heard, answer = answered
    answer.update(decision=DECISION)
    assert ask("4").output == "Decision 4.\n  as told\n"
    answer.clear()
    answer.update(stop=STOP)
    assert ask("2", "--stop").output == "Stop 2.\n"
    assert heard == [{"decision": 4}, {"stop": 2}]


def test_as_json(answered):
    ask, _, answer = answered
    answer.update(decision=DECISION, stop=None)
    assert json.loads(ask("--json").output) == answer


def test_nothing_yet_is_said_and_what_is_refused_ends_with_1(answered):
    ask, _, answer = answered
    answer.update(decision=None, stop=None)
    assert ask().output == "Nothing was decided yet.\n\nNothing has held the base yet.\n"
    answer.clear()
    answer.update(accepted=False, error="why: decision 9: there was none yet")
    done = ask("9")
    assert (done.output, done.exit_code) == ("rfnav: why: decision 9: there was none yet\n", 1)


def test_a_decision_that_is_remembered_no_more_is_in_the_journal(answered, tmp_path: Path):
    ask, _, answer = answered
    answer.update(accepted=False, error="why: decision 1: is not remembered; 9 to 9 are")
    assert ask("1").exit_code == 1  # there is no journal
    nowhere = elect(Ballot(), (), ConsensusConfig(mode="strict"))
    world = SimpleNamespace(body=SimpleNamespace(step=9), frontiers=())
    with Journal(tmp_path / "decisions.jsonl") as journal:
        journal.write("goal", text="mug")
        journal.write("decision", brief=Brief("mug", 0, ()), **explain(nowhere, world, "nearest"))
    assert ask("1").output.startswith('Decision 1 of the search for "mug".\n')
    assert ask("1", "--stop").exit_code == 1
    answer["error"] = "why: decision 2: there is none yet; the last is 1"
    done = ask("2")  # which the journal does not have, either
    told = "rfnav: why: decision 2: there is none yet; the last is 1\n"
    assert (done.output, done.exit_code) == (told, 1)


def test_of_a_journal(tmp_path: Path):
    path = tmp_path / "decisions.jsonl"
    with Journal(path) as journal:
        journal.write("goal", text="mug")
        for at_s, now in ((2.0, "held: plan: old"), (3.0, "searching"), (4.0, "held: frame: none")):
            journal.write("standing", at_s=at_s, now=now)
    last, first = run("--stop", "--journal", str(path)), run("1", "--stop", "--journal", str(path))
    assert last.output.startswith("Stop 2 (held, frame): ")
    assert "It began at 4.0 s; it goes on." in last.output
    assert "It began at 2.0 s; it lasted 1.0 s, then: searching." in first.output
    assert run("--journal", str(path)).output == "Nothing was decided yet.\n"
    none = run("3", "--journal", str(path))
    assert (none.exit_code, none.output) == (1, f"rfnav: {path}: decision 3: there is none\n")
    as_json = json.loads(run("--stop", "--json", "--journal", str(path)).output)
    assert (as_json["stop"]["number"], as_json["stop"]["kind"]) == (2, "frame")
