"""Who is on the bus, and who may be: asked of a session, and judged."""

import importlib.metadata
import json
import time
from collections.abc import Iterator
from dataclasses import astuple
from typing import Any, Final

import zenoh

from runtime.config import Config
from runtime.doctor.advertised import TOKENS, Advertised, read_token
from runtime.doctor.diagnosis import Diagnosis, bad, ok, warning
from runtime.doctor.hearing import Hearing, NetworkHeard
from runtime.errors import SensorError
from runtime.robot.dialects.choice import spoken
from runtime.robot.exposure import doubtful, exposed
from runtime.robot.json_text import parse_json
from runtime.robot.publications import cmd_vel_topic
from runtime.robot.session import DEFAULT_LISTEN, STATUS

ASK_S: Final = 1.0  # for those that are there: they answer in milliseconds
LINK_S: Final = 3.0  # for a session to find whom it was told to connect to
SETTLE_S: Final = 0.3  # for what the other side declares to be known here
COMMANDS_S: Final = 0.5  # for whoever commands velocities
ADMIN: Final = ("@/*/router", "@/*/peer")
MOST: Final = 10_000  # tokens that are read


def heard_of(session: Any, config: Config) -> tuple[NetworkHeard, tuple[Advertised, ...]]:
    """Whom the session reaches, and what they say that they publish. Waits up to LINK_S for a
    first."""
    until_s = time.monotonic() + LINK_S
    while not any(links := _links(session)) and time.monotonic() < until_s:
        time.sleep(0.05)
    if not any(links):
        return NetworkHeard(), ()
    time.sleep(SETTLE_S)
    dialect, cmd_vel = spoken(config.bus), cmd_vel_topic(config.bus)
    base = _listens(session, dialect.publishes_on(cmd_vel))
    commands: list[object] = []
    commanded = session.declare_subscriber(dialect.listens_on(cmd_vel), commands.append)
    tokens = (key for pattern in TOKENS.values() for key in _tokens(session, pattern))
    advertised = {found for key in tokens if (found := read_token(key)) is not None}
    told = {one for pattern in ADMIN for one in _versions(session, pattern)}
    runtime = _answers(session, config.bus.key(STATUS))
    time.sleep(COMMANDS_S)
    commanded.undeclare()
    network = NetworkHeard(*_links(session), tuple(sorted(told)), base, len(commands), runtime)
    return network, tuple(sorted(advertised, key=astuple))


def _links(session: Any) -> tuple[int, int]:
    """How many routers and peers."""
    return len(session.info.routers_zid()), len(session.info.peers_zid())


def _tokens(session: Any, pattern: str) -> Iterator[str]:
    for n, reply in enumerate(session.liveliness().get(pattern, timeout=ASK_S)):
        if reply.ok is not None and n < MOST:
            yield str(reply.ok.key_expr)


def _versions(session: Any, pattern: str) -> Iterator[str]:
    """Of routers and peers that tell of themselves: `router 1.10.2`."""
    for reply in session.get(pattern, timeout=ASK_S):
        if reply.ok is None:
            continue
        key = str(reply.ok.key_expr)
        try:
            told = parse_json(reply.ok.payload.to_bytes(), key)
        except SensorError:
            continue  # whoever answers there with something else says nothing of a version
        version = str(told.get("version", ""))[:40]
        if version and version.isprintable():
            yield f"{key.rpartition('/')[2]} {version.lstrip('v')}"


def _answers(session: Any, key: str) -> bool:
    """Whether somebody serves a query, answered or not."""
    querier = session.declare_querier(key)
    try:
        return _matched(querier)
    finally:
        querier.undeclare()


def _listens(session: Any, key: str) -> bool:
    """Whether somebody else has subscribed to a topic; nothing is published."""
    publisher = session.declare_publisher(key, allowed_destination=zenoh.Locality.REMOTE)
    try:
        return _matched(publisher)
    finally:
        publisher.undeclare()


def _matched(declared: Any) -> bool:
    """Whether somebody is at the other end. A client is told by its router, a moment later."""
    until_s = time.monotonic() + SETTLE_S
    while not (there := bool(declared.matching_status.matching)) and time.monotonic() < until_s:
        time.sleep(0.01)
    return there


def judge_network(hearing: Hearing, config: Config) -> Iterator[Diagnosis]:
    """The link, versions, what others reach."""
    network, bus = hearing.network, config.bus
    connects = [end for name, end in bus.endpoints if name == "bus.connect"]
    listens = [end for name, end in bus.endpoints if name == "bus.listen"]
    ours = f"Zenoh {importlib.metadata.version('eclipse-zenoh')} here"
    if network.error and not connects:
        doors = ", ".join(map(json.dumps, listens))
        yield bad(
            "bus",
            network.error,
            "another listens there: where that is a bridge or a router, connect to it; where it is "
            "an rfnav run, look at the robot while it does not run",
            ("bus.mode", '"client"'),
            ("bus.connect", f"[{doors}]"),
        )
    elif network.error:
        yield bad("bus", network.error, _remedy(connects))
    elif network.alone:
        where = f"nobody is at {', '.join(connects)}"
        if not connects:
            where = f"nobody connected to {', '.join(listens)}, where rfnav listens"
        yield bad("bus", f"{where} ({ours})", _remedy(connects))
    else:
        there = ", ".join((*network.told, ours))
        linked = f"{_count(network.routers, 'router')} and {_count(network.peers, 'peer')}"
        yield ok("bus", f"{bus.mode}, linked to {linked}; {there}")
        if network.runtime:
            yield ok("rfnav", "an rfnav run is on this bus")
    for line in doubtful(bus):
        yield warning("mode", line, 'bus.mode = "client"', ("bus.mode", '"client"'))
    open_to = exposed(bus, config.base)
    for line in open_to:
        yield warning("access", line, "as intended? docs/security.md says who may do what")
    if not open_to:
        yield ok("access", "nothing of it is open beyond this computer")


def _count(number: int, what: str) -> str:
    return f"{number} {what}" if number == 1 else f"{number} {what}s"


def _remedy(connects: list[str]) -> str:
    if connects:
        return "start the bridge or router there, or set bus.connect to where it is"
    return "start the bridge, and connect to it: see below"


def first_steps(network: NetworkHeard, config: Config) -> Iterator[str]:
    """What to do, in lines to be copied, where there is nobody on the bus."""
    if not network.alone:
        return
    endpoint = next((end for name, end in config.bus.endpoints if name == "bus.connect"), "")
    if (network.error and not endpoint) or endpoint.startswith("tls/"):
        return  # somebody is there; docs/security.md has what a bridge needs beyond this computer
    endpoint = endpoint or DEFAULT_LISTEN[0]
    yield from (
        "",
        "The robot's ROS 2 comes to rfnav through zenoh-bridge-ros2dds. On the robot's computer:",
        "",
        "  1. start the drivers of its camera and its base; `ros2 topic list` shows them",
        "  2. export ROS_DISTRO=humble ROS_LOCALHOST_ONLY=1  # ROS_DISTRO: that of those drivers",
        f"  3. zenoh-bridge-ros2dds --listen {endpoint} --no-multicast-scouting",
        f"  4. rfnav doctor --set bus.mode=client --set 'bus.connect=[\"{endpoint}\"]'",
    )
