"""What a user sees of the doctor; what it finds is given."""

import json

import pytest
from click.testing import CliRunner, Result
from hearings import healthy

import runtime.commands.doctor as command
from runtime.__main__ import cli
from runtime.config import Config
from runtime.doctor.diagnosis import bad, ok, warning
from runtime.doctor.examination import Examined, Instruments
from runtime.doctor.hearing import NetworkHeard

WELL = [ok("bus", "client, linked to 1 router")]
ILL = [
    *WELL,
    warning("governor", "powersave", "sudo cpupower frequency-set --governor performance"),
    bad("depth", "nothing came", 'bus.topics.depth = "a/b"', ("bus.topics.depth", '"a/b"')),
]


@pytest.fixture
def finds(monkeypatch: pytest.MonkeyPatch) -> dict:
    """What is found, and what was asked."""
    told: dict = {"found": WELL}

    def examine(config: Config, seconds: float, turn: bool, by: Instruments) -> Examined:
        told["asked"] = seconds, turn, config.bus.prefix
        hearing = healthy(config)
        hearing.network = told.get("network", hearing.network)
        return Examined(hearing, {"bus": told["found"][:1], "others": told["found"][1:]})

    monkeypatch.setattr(command, "examine", examine)
    return told


def run(*arguments: str) -> Result:
    return CliRunner().invoke(cli, ["doctor", *arguments])


def test_all_is_well(finds: dict):
    done = run("--seconds", "3", "--set", "bus.prefix=r1")
    assert done.exit_code == 0, done.output
    assert finds["asked"] == (3.0, False, "r1")
    lines = done.output.splitlines()
    assert lines[0].split()[:2] == ["topic", "Hz"]
    assert lines[1].startswith("r1/camera/color/image_raw")
    assert "  ok        bus               client, linked to 1 router" in lines
    assert lines[-1] == "a search can start: all is well"


def test_what_is_not_has_its_remedy_below_it_and_the_lines_that_fit_at_the_end(finds: dict):
    finds["found"] = ILL
    done = run()
    assert done.exit_code == 1
    lines = done.output.splitlines()
    at = next(n for n, line in enumerate(lines) if line.startswith("  warning   governor"))
    assert lines[at + 1].strip().startswith("-> sudo cpupower")
    assert lines[-4:-2] == ["[bus.topics]", 'depth = "a/b"']
    assert lines[-1] == "NO SEARCH CAN START: 1 bad, 1 warning"


def test_who_sees_nothing_is_told_what_to_type(finds: dict):
    finds["network"] = NetworkHeard()
    told = run().output
    assert "  2. export ROS_DISTRO=humble ROS_LOCALHOST_ONLY=1" in told
    assert "  3. zenoh-bridge-ros2dds --listen tcp/127.0.0.1:7447 --no-multicast-scouting" in told


def test_as_json(finds: dict):
    finds["found"] = ILL
    done = run("--json")
    assert done.exit_code == 1
    told = json.loads(done.stdout)
    assert told["ready"] is False
    assert told["found"][2] == {
        "part": "others", "about": "depth", "grade": "bad", "told": "nothing came",
        "remedy": 'bus.topics.depth = "a/b"', "settings": [["bus.topics.depth", '"a/b"']],
    }  # fmt: skip
    assert told["topics"]["odom"]["rate_hz"] == pytest.approx(20.0, rel=0.02)
    assert told["topics"]["battery"]["received"] == 0


def test_a_configuration_that_is_none_is_an_error_and_no_finding(finds: dict):
    assert run("--set", "camera.z_m=900").exit_code != 0
    assert "asked" not in finds
    assert run("--seconds", "0").exit_code == 2
