"""Who is on the bus: by default nobody from beyond this computer, and with certificates nobody who
has none. Real Zenoh, real TLS."""

import json
import socket
import threading
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
import zenoh
from authority import certified

from runtime.clock import SystemClock
from runtime.core.types import Pose
from runtime.errors import BusError, ConfigError
from runtime.robot import wire
from runtime.robot.bus import Bus
from runtime.robot.endpoints import TlsConfig
from runtime.robot.session import DEFAULT_LISTEN, STATUS, BusConfig, check, open_session

PATIENCE_S = 20.0
SHORT_S = 0.5  # what has not come by then will not: a friend asks and is answered meanwhile
TLS = "transport/link/tls"
Strange = Callable[[TlsConfig, TlsConfig], Mapping[str, object]]


def free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


def listening(port: int) -> set[str]:
    """Addresses of this computer that somebody listens on at a TCP port, as /proc has them."""
    found = set()
    for name in ("tcp", "tcp6"):
        for line in Path(f"/proc/net/{name}").read_text(encoding="ascii").splitlines()[1:]:
            local, state = line.split()[1], line.split()[3]
            if state == "0A" and int(local.partition(":")[2], 16) == port:
                found.add(local.partition(":")[0])
    return found


def bound(kind: str) -> set[str]:
    """Everything that is bound or joined just now: lines of /proc/net/KIND."""
    lines = Path(f"/proc/net/{kind}").read_text(encoding="ascii").splitlines()[1:]
    return {line.split()[1] for line in lines if line.strip()}


def test_by_default_it_is_this_computers_alone() -> None:
    assert BusConfig().endpoints == (("bus.listen", "tcp/127.0.0.1:7447"),)
    assert DEFAULT_LISTEN == ("tcp/127.0.0.1:7447",)
    assert BusConfig(connect=("tcp/127.0.0.1:5",)).endpoints == (
        ("bus.connect", "tcp/127.0.0.1:5"),
    )


def test_nothing_is_open_but_the_endpoint(monkeypatch: pytest.MonkeyPatch) -> None:
    port = free_port()
    monkeypatch.setattr(
        "runtime.robot.session.DEFAULT_LISTEN", (f"tcp/127.0.0.1:{port}",)
    )  # another runtime may be up
    before = {kind: bound(kind) for kind in ("udp", "udp6", "igmp")}
    with open_session(BusConfig()):
        assert listening(port) == {"0100007F"}
        for kind, was in before.items():
            assert bound(kind) <= was, kind
        admin = "@/**"
        with open_session(BusConfig(connect=(f"tcp/127.0.0.1:{port}",))) as local:
            told = [r for r in local.get(admin, timeout=SHORT_S) if r.ok is not None]
            own = str(local.zid())  # a session answers itself, and nobody else
            assert {str(r.replier_id.zid) for r in told if r.replier_id} <= {own}


def test_a_check_before_the_start_refuses_the_same() -> None:
    with pytest.raises(ConfigError, match=r"^bus\.connect: 'tcp/10\.0\.0\.2:7447' is beyond"):
        check(BusConfig(connect=("tcp/10.0.0.2:7447",)))
    with pytest.raises(ConfigError, match=r"^bus\.connect: a client needs a router"):
        check(BusConfig(mode="client"))
    given = BusConfig(listen=("tls/0.0.0.0:7447",), tls=TlsConfig("a", "b", "c"))
    check(given)
    with pytest.raises(ConfigError, match=r"^bus\.tls\.ca: a: No such file"):
        check(given, files=True)
    with pytest.raises(ConfigError, match=r"^bus\.tls\.ca: a: No such file"):
        open_session(given)


def test_a_port_that_is_taken_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    with socket.create_server(("127.0.0.1", 0)) as taken:
        endpoint = f"tcp/127.0.0.1:{taken.getsockname()[1]}"
        monkeypatch.setattr("runtime.robot.session.DEFAULT_LISTEN", (endpoint,))
        for config, remedy in ((BusConfig(listen=(endpoint,)), ""), (BusConfig(), "if that is a")):
            said = rf"^bus \(peer, {endpoint}\): cannot be opened: .*{remedy}"
            with pytest.raises(BusError, match=said) as told:
                open_session(config)
            assert "\n" not in str(told.value)
            assert ("bus.connect" in str(told.value)) is bool(remedy)


def test_a_bridge_that_is_not_there_is_told_with_what_to_look_at() -> None:
    endpoint = f"tcp/127.0.0.1:{free_port()}"
    said = rf"^bus \(client, {endpoint}\): cannot be opened: .*; is the bridge or router up, and "
    with pytest.raises(BusError, match=said) as told:
        open_session(BusConfig(mode="client", connect=(endpoint,)))
    assert " at /" not in str(told.value)


@contextmanager
def answering(config: BusConfig) -> Iterator[Bus]:
    """The runtime's side of the bus, that answers whoever asks."""
    over = threading.Event()
    with Bus(config, SystemClock()) as bus:

        def serve() -> None:
            while not over.is_set():
                bus.wait_request(0.05)
                while (request := bus.request()) is not None:
                    request.reply({"state": "ready"})

        thread = threading.Thread(target=serve)
        thread.start()
        try:
            yield bus
        finally:
            over.set()
            thread.join(PATIENCE_S)


def asked(session: Any, timeout_s: float) -> list[Any]:
    """What is answered to rfnav/status."""
    replies = session.get(STATUS, payload=b"{}", timeout=timeout_s)
    return [json.loads(reply.ok.payload.to_bytes()) for reply in replies if reply.ok is not None]


def until(met: Callable[[], object]) -> None:
    by = time.monotonic() + PATIENCE_S
    while not met():
        assert time.monotonic() < by, "the friend is not there"
        time.sleep(0.01)


def tls_files(tls: TlsConfig) -> dict[str, object]:
    return {
        f"{TLS}/root_ca_certificate": tls.ca,
        f"{TLS}/enable_mtls": True,
        f"{TLS}/connect_certificate": tls.certificate,
        f"{TLS}/connect_private_key": tls.private_key,
    }


def stranger(endpoint: str, settings: Mapping[str, object], mode: str) -> Any:
    """A session of somebody who does as he likes; None where he is shown the door at once."""
    config = zenoh.Config()
    told = {
        "mode": mode, "connect/endpoints": [endpoint], "listen/endpoints": [],
        "scouting/multicast/enabled": False, "connect/timeout_ms": 1000, **settings,
    }  # fmt: skip
    for key, value in told.items():
        config.insert_json5(key, json.dumps(value))
    with suppress(zenoh.ZError):
        return zenoh.open(config)
    return None


def another_authority(robot: TlsConfig, own: TlsConfig) -> Mapping[str, object]:
    """A certificate that he made himself, of the same name; he takes the robot's for good."""
    return tls_files(replace(own, ca=robot.ca))


def the_robots_authority_but_no_certificate(robot: TlsConfig, _: TlsConfig) -> Mapping[str, object]:
    return {f"{TLS}/root_ca_certificate": robot.ca}


def another_key(robot: TlsConfig, own: TlsConfig) -> Mapping[str, object]:
    """The robot's own certificate, which is no secret, with another key."""
    return tls_files(replace(robot, private_key=own.private_key))


def in_the_clear(_: TlsConfig, __: TlsConfig) -> Mapping[str, object]:
    return {}


@pytest.mark.parametrize("mode", ["client", "peer"])
@pytest.mark.parametrize(
    "strange",
    [another_authority, the_robots_authority_but_no_certificate, another_key, in_the_clear],
)
def test_a_stranger_can_neither_command_nor_feed_nor_ask(
    tmp_path: Path, strange: Strange, mode: str
) -> None:
    robot = certified(tmp_path / "ours", "robot", "127.0.0.1")
    laptop = certified(tmp_path / "ours", "laptop", "localhost")
    his = certified(tmp_path / "his", "laptop", "127.0.0.1")
    # He looks past whose certificate the robot has: it is the robot that has to refuse.
    settings = {f"{TLS}/verify_name_on_connect": False, **strange(robot, his)}
    port = free_port()
    protocol = "tcp" if strange is in_the_clear else "tls"
    given = BusConfig(listen=(f"tls/127.0.0.1:{port}",), tls=robot)
    friends = BusConfig(mode="client", connect=(f"tls/127.0.0.1:{port}",), tls=laptop)
    commands: list[bytes] = []
    odometry = wire.encode_odometry(Pose(1, 2, 0.5), 10**9)

    def fed() -> int:
        return bus.health()[given.topics.odom].received if bus.health() else 0

    with answering(given) as bus, open_session(friends) as base, open_session(friends) as friend:
        base.declare_subscriber("cmd_vel", lambda s: commands.append(s.payload.to_bytes()))
        until(lambda: asked(friend, SHORT_S) == [{"state": "ready"}])
        until(lambda: (friend.put("cmd_vel", b"friend"), b"friend" in commands)[1])
        session = stranger(f"{protocol}/127.0.0.1:{port}", settings, mode)
        if session is not None:
            with session:
                for _ in range(5):
                    session.put("cmd_vel", b"stranger")
                    session.put("odom", odometry)
                    assert asked(session, SHORT_S / 5) == []
        # What he sent has had its time: a friend's comes through meanwhile.
        assert fed() == 0
        until(lambda: (friend.put("odom", odometry), fed())[1])
        assert asked(friend, PATIENCE_S) == [{"state": "ready"}]
        assert b"stranger" not in commands


def test_a_robot_speaks_to_no_router_that_is_another_than_it_was_told(tmp_path: Path) -> None:
    """The certificate of the same authority, but of another host; and of another authority."""
    robot = certified(tmp_path / "ours", "robot", "localhost")
    elsewhere = certified(tmp_path / "ours", "elsewhere", "192.0.2.7")
    router = certified(tmp_path / "ours", "router", "127.0.0.1")
    his = certified(tmp_path / "his", "router", "127.0.0.1")
    for tls, meets in ((elsewhere, False), (his, False), (router, True)):
        endpoint = f"tls/127.0.0.1:{free_port()}"
        with open_session(BusConfig(listen=(endpoint,), tls=tls)):
            config = BusConfig(mode="client", connect=(endpoint,), tls=robot)
            if meets:
                open_session(config).close()
                continue
            with pytest.raises(BusError, match="cannot be opened") as told:
                open_session(config)
            assert "\n" not in str(told.value)
