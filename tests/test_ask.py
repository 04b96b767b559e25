"""scripts/ask: what it asks, prints and ends with, over a real bus."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest
from lockstep_double import free_port
from places import ROOT

from runtime.robot.session import BusConfig, open_session

SCRIPT = ROOT / "scripts" / "ask"
GOAL = '{"goal": "toilet"}'


def run(*arguments: str) -> subprocess.CompletedProcess[str]:
    path = f"{Path(sys.executable).parent}:{os.environ['PATH']}"  # where there is no .venv
    return subprocess.run(
        [SCRIPT, *arguments], capture_output=True, text=True, env={**os.environ, "PATH": path}
    )


@pytest.mark.parametrize(
    ("arguments", "asked", "answer", "status"),
    [
        (("rfnav/goal", GOAL), json.loads(GOAL), {"accepted": True}, 0),
        (("rfnav/goal", GOAL), json.loads(GOAL), {"accepted": False, "error": "busy"}, 1),
        (("rfnav/status", "{}"), {}, {"state": "ready"}, 0),
    ],
)
def test_what_is_answered_is_printed(
    arguments: tuple[str, str], asked: dict, answer: dict, status: int
) -> None:
    endpoint, heard = f"tcp/127.0.0.1:{free_port()}", []
    with open_session(BusConfig(listen=(endpoint,))) as session:

        def reply(query) -> None:
            heard.append(json.loads(query.payload.to_string()))
            query.reply(query.key_expr, json.dumps(answer))

        session.declare_queryable(arguments[0], reply)
        done = run(*arguments, endpoint)
    assert (heard, json.loads(done.stdout), done.stderr) == ([asked], answer, "")
    assert done.returncode == status


def test_without_a_runtime_it_says_what_to_start() -> None:
    endpoint = f"tcp/127.0.0.1:{free_port()}"
    done = run("rfnav/status", "{}", endpoint)
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.startswith(f"ask: {endpoint}: nobody listens: start the bridge")
    with open_session(BusConfig(listen=(endpoint,))):
        done = run("rfnav/status", "{}", endpoint)
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr == (
        f"ask: {endpoint}: nobody answers on rfnav/status: is rfnav run up, and bus.prefix before "
        "the name?\n"
    )


def test_without_a_question_it_says_how_to_ask() -> None:
    done = run()
    assert done.returncode == 2
    assert 'scripts/ask rfnav/goal \'{"goal": "toilet"}\'' in done.stderr
