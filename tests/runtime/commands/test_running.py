"""How a command reaches a runtime that runs on this computer."""

import json
from collections.abc import Iterator

import pytest
import zenoh

from hil_sim.driving.link import free_port
from runtime.commands.running import running
from runtime.errors import BusError, SensorError, SilentError
from runtime.robot.session import BusConfig, open_session


@pytest.fixture
def config() -> BusConfig:
    return BusConfig(listen=(f"tcp/0.0.0.0:{free_port()}",), prefix="rosie")


@pytest.fixture
def bus(config: BusConfig) -> Iterator[zenoh.Session]:
    end = config.listen[0].replace("0.0.0.0", "127.0.0.1")
    with open_session(BusConfig(listen=(end,))) as session:
        yield session


def test_it_is_asked_where_the_configuration_says(config: BusConfig, bus: zenoh.Session):
    heard = []

    def reply(query: zenoh.Query) -> None:
        heard.append(json.loads(query.payload.to_string()))
        query.reply(query.key_expr, json.dumps({"state": "ready"}))

    bus.declare_queryable("rosie/rfnav/status", reply)
    with running(config) as runtime:
        assert runtime.ask("status", {"n": 1}) == {"state": "ready"}
    assert heard == [{"n": 1}]


def test_an_answer_that_is_none_is_told(config: BusConfig, bus: zenoh.Session):
    bus.declare_queryable("rosie/rfnav/why", lambda query: query.reply(query.key_expr, "[]"))
    with running(config) as runtime, pytest.raises(SensorError, match="rosie/rfnav/why: JSON list"):
        runtime.ask("why", {})


def test_where_nobody_answers_that_is_said(config: BusConfig, bus: zenoh.Session):
    told = r"tcp/127.0.0.1:\d+: nobody answers on rosie/rfnav/why: is rfnav run up\?"
    with running(config) as runtime, pytest.raises(BusError, match=told):
        runtime.ask("why", {})


def test_where_somebody_is_silent_that_is_said(config: BusConfig, bus: zenoh.Session):
    unanswered: list[zenoh.Query] = []
    bus.declare_queryable("rosie/rfnav/why", unanswered.append)
    told = r"rfnav run is there, and has not answered on rosie/rfnav/why within 0.1 s"
    with running(config) as runtime, pytest.raises(SilentError, match=told):
        runtime.ask("why", {}, 0.1)
    unanswered.clear()


def test_where_nobody_listens_that_is_said(config: BusConfig):
    told = r"tcp/127.0.0.1:\d+: nobody listens: is rfnav run up\?"
    with pytest.raises(BusError, match=told), running(config):
        pass
