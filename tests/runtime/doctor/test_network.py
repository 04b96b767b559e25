"""Who is on the bus: what is told of it, and what two sessions on loopback see of each other."""

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import pytest
import zenoh
from hearings import healthy

from hil_sim.driving.link import free_port
from runtime.config import Config, load
from runtime.doctor.advertised import Advertised
from runtime.doctor.diagnosis import Diagnosis, Grade
from runtime.doctor.hearing import Hearing, NetworkHeard
from runtime.doctor.network import first_steps, heard_of, judge_network
from runtime.robot.session import BusConfig, open_session

CONFIG = load(None, ["bus.mode=client", 'bus.connect=["tcp/127.0.0.1:7447"]'])


def found(network: NetworkHeard, config: Config = CONFIG) -> dict[str, Diagnosis]:
    hearing: Hearing = replace(healthy(config), network=network)
    return {one.about: one for one in judge_network(hearing, config)}


def test_a_bus_with_somebody_on_it():
    told = found(NetworkHeard(routers=1, told=("router 1.5.0",), base=True))
    assert {one.grade for one in told.values()} == {Grade.OK}
    assert told["bus"].told.startswith(
        "client, linked to 1 router and 0 peers; router 1.5.0, Zenoh "
    )
    assert "nothing of it is open" in told["access"].told


def test_nobody_there_says_what_to_start():
    told = found(NetworkHeard())["bus"]
    assert told.grade is Grade.BAD
    assert "bus.connect" in told.remedy
    alone = found(NetworkHeard(), Config())["bus"]
    assert "where rfnav listens" in alone.told
    assert "see below" in alone.remedy
    steps = list(first_steps(NetworkHeard(), Config()))
    assert steps == list(first_steps(NetworkHeard(), CONFIG))
    assert any("zenoh-bridge-ros2dds --listen tcp/127.0.0.1:7447" in step for step in steps)
    assert steps[-1].endswith("""'bus.connect=["tcp/127.0.0.1:7447"]'""")
    assert list(first_steps(NetworkHeard(peers=1), CONFIG)) == []


def test_a_bus_that_cannot_be_opened():
    broken = NetworkHeard(error="bus: cannot be opened")
    assert found(broken)["bus"].grade is Grade.BAD
    assert list(first_steps(broken, CONFIG))
    taken = found(broken, Config())["bus"]  # it only listens: another does so there
    assert taken.settings[1] == ("bus.connect", '["tcp/127.0.0.1:7447"]')
    assert list(first_steps(broken, Config())) == []


def test_what_is_open_beyond_this_computer_is_warned_of():
    rover = load(None, ["base.kind=mavlink", "base.link=udpin:0.0.0.0:14550"])
    told = found(NetworkHeard(peers=1), rover)["access"]
    assert told.grade is Grade.WARNING
    assert told.told.startswith("base.link: ")


def test_a_peer_that_a_router_of_rmw_zenoh_would_leave_alone_is_told_so():
    settings = ["bus.dialect=rmw_zenoh", 'bus.connect=["tcp/127.0.0.1:7447"]']
    told = found(NetworkHeard(peers=1), load(None, settings))["mode"]
    assert told.grade is Grade.WARNING
    assert told.settings == (("bus.mode", '"client"'),)


@pytest.fixture
def both() -> Iterator[tuple[Any, Any, Config]]:
    """A robot's session, ours, and our configuration."""
    endpoint = f"tcp/127.0.0.1:{free_port()}"
    config = load(None, [f'bus.connect=["{endpoint}"]'])
    robot: Any = open_session(BusConfig(listen=(endpoint,)))
    ours: Any = open_session(config.bus)
    yield robot, ours, config
    ours.close()
    robot.close()


def test_an_empty_robot_is_reached_and_offers_nothing(both: tuple[Any, Any, Config]):
    _, ours, config = both
    network, advertised = heard_of(ours, config)
    assert (network.peers, network.base, network.runtime) == (1, False, False)
    assert advertised == ()


def test_tokens_a_base_and_a_runtime_are_noticed(both: tuple[Any, Any, Config]):
    robot, ours, config = both
    keys = "@/z/@ros2_lv/MP/oak§rgb/sensor_msgs§msg§Image/:::", "@/z/@ros2_lv/MP/nonsense"
    tokens = [robot.liveliness().declare_token(key) for key in keys]
    base = robot.declare_subscriber("cmd_vel", lambda sample: None)
    runtime = robot.declare_queryable("rfnav/status", lambda query: None)  # it is busy
    network, advertised = heard_of(ours, config)
    assert advertised == (Advertised("oak/rgb", "sensor_msgs/msg/Image", "ros2dds"),)
    assert network.base
    assert network.runtime
    for one in (*tokens, base, runtime):
        one.undeclare()


def test_a_client_of_a_bridge_notices_them_too():
    endpoint = f"tcp/127.0.0.1:{free_port()}"
    told = zenoh.Config()
    told.insert_json5("mode", '"router"')
    told.insert_json5("listen/endpoints", f'["{endpoint}"]')
    told.insert_json5("scouting/multicast/enabled", "false")
    config = load(None, ["bus.mode=client", f'bus.connect=["{endpoint}"]'])
    with zenoh.open(told) as bridge, open_session(config.bus) as ours:
        assert not heard_of(ours, config)[0].base
        base = bridge.declare_subscriber("cmd_vel", lambda sample: None)
        with open_session(config.bus) as running:
            runtime = running.declare_queryable("rfnav/status", lambda query: None)
            network, _ = heard_of(ours, config)
            runtime.undeclare()
        base.undeclare()
    assert (network.routers, network.base, network.runtime) == (1, True, True)


def test_versions_are_told_by_those_who_tell(both: tuple[Any, Any, Config]):
    robot, ours, config = both

    def tell(query: Any) -> None:
        query.reply("@/abc/router", '{"version": "v1.5.0-mod", "more": [1]}')
        query.drop()

    telling = robot.declare_queryable("@/abc/router", tell)
    lying = robot.declare_queryable("@/abd/router", lambda q: q.reply("@/abd/router", b"\xff{"))
    network, _ = heard_of(ours, config)
    assert network.told == ("router 1.5.0-mod",)
    for one in (telling, lying):
        one.undeclare()
