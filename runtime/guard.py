"""The watchdog of the control loop, in a process of its own: `rfnav guard`.

No thread of the runtime survives C code that keeps the interpreter's lock, SIGSTOP, kill -9 or the
out-of-memory killer. This process is told of every turn of the control loop; when the base was told
to move and no other turn comes, it commands zero, until the base is at rest or a hand speaks. It
knows no ROS, no NumPy and no configuration: what it is to say and where it is told (`Orders`).
"""

import argparse
import json
import math
import os
import signal
import socket
import struct
import sys
import threading
import time
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Final, Self

import zenoh

STILL: Final = b"\x00"  # a turn of control after which the base stands
MOVING: Final = b"\x01"  # one after which it was told to move
BYE: Final = b"bye"  # the control loop ends, and has commanded zero
READY: Final = b"ready"  # what is answered once, when somebody on the bus is reached
SILENCE_S: Final = 0.2  # without a turn
AGAIN_S: Final = 0.05  # between two zeros
LEAST_S: Final = 0.5  # zeros at least for so long
BLIND_S: Final = 2.0  # and without odometry, for so long
LONGEST_S: Final = 10.0  # a base that does not obey by then does not obey
HAND_S: Final = 0.5  # after what a hand said last
REST_S: Final = 0.3  # odometry tells the same place for so long: the base is at rest
REST_M, REST_SHARE = 0.003, 0.003  # of what it tells, what is the same (half the sine of a turn)
LOOK_S: Final = 0.1  # how often it is looked whether somebody is there
LARGEST: Final = 1 << 16  # bytes of a message
FIFO_PRIORITY: Final = 21  # just above the control loop's
ZID: Final = "{zid}"  # in a token of the orders: where the session's id goes
ATTACHMENT: Final = struct.Struct("<qqB16s")  # number, ns since 1970, bytes of the gid, the gid


@dataclass(frozen=True)
class Orders:
    """What a runtime has its guard do. `session`: Zenoh's settings; `zero`: a message for
    `cmd_vel`, in hexadecimal; `odom`, `teleop`: keys, "" where there is none; `child`: odometry
    names a child frame (it is no PoseStamped); `gid`: of whoever says zero, in hexadecimal, where
    messages have an attachment, else ""; `tokens`: of liveliness, with `ZID` in them."""

    session: dict[str, Any]
    cmd_vel: str
    zero: str
    odom: str
    teleop: str
    child: bool
    gid: str
    tokens: list[str]

    def told(self) -> bytes:
        return json.dumps(asdict(self)).encode()

    @classmethod
    def read(cls, told: bytes) -> Self:
        """ValueError, TypeError or KeyError for what is none."""
        return cls(**json.loads(told))


def place(payload: bytes, child: bool) -> tuple[float, ...]:
    """Position (m) and orientation (a quaternion) of a nav_msgs/Odometry, or of a PoseStamped, in
    CDR. struct.error or IndexError for what is none."""
    order, at = "<" if payload[1] else ">", 12
    for _ in range(2 if child else 1):
        at += -at % 4
        at += 4 + int(struct.unpack_from(order + "I", payload, at)[0])
    at += -(at - 4) % 8  # alignment counts from after the first four bytes
    return struct.unpack_from(order + "7d", payload, at)


class Rest:
    """Whether a base is at rest, by its odometry. Times are monotonic seconds."""

    def __init__(self) -> None:
        self._place: tuple[float, ...] = ()
        self._since_s = self.spoke_s = -math.inf

    def note(self, where: tuple[float, ...], now_s: float) -> None:
        self.spoke_s = now_s
        bounds = (REST_M,) * 3 + (REST_SHARE,) * 4
        same = self._place and all(
            abs(a - b) <= most for a, b, most in zip(where, self._place, bounds, strict=True)
        )
        if not same:
            self._place, self._since_s = where, now_s

    def over(self, now_s: float, braked_s: float) -> bool:
        """Whether enough was commanded, `braked_s` after it began."""
        if braked_s < LEAST_S:
            return False
        if now_s - self.spoke_s > REST_S:
            return braked_s >= BLIND_S
        return now_s - self._since_s >= REST_S or braked_s >= LONGEST_S


class Brake:
    """The robot's side: a session of its own, and zero on `cmd_vel`."""

    def __init__(self, orders: Orders) -> None:
        config = zenoh.Config()
        for name, value in orders.session.items():
            # Where systemd puts credentials is another place in each unit.
            config.insert_json5(name, os.path.expandvars(json.dumps(value)))
        self._lock, self._rest, self._hand_s = threading.Lock(), Rest(), -math.inf
        self._child, self._zero = orders.child, bytes.fromhex(orders.zero)
        self._gid, self._sent = bytes.fromhex(orders.gid), 0
        self._session: Any = zenoh.open(config)
        self._cmd_vel = self._session.declare_publisher(
            orders.cmd_vel,
            congestion_control=zenoh.CongestionControl.DROP,  # a link that stands holds up nothing
            priority=zenoh.Priority.INTERACTIVE_HIGH,
            express=True,
        )
        if orders.odom:
            self._session.declare_subscriber(orders.odom, self._moved)
        if orders.teleop:
            self._session.declare_subscriber(orders.teleop, self._spoken)
        zid = str(self._session.zid())
        self._tokens = [
            self._session.liveliness().declare_token(token.replace(ZID, zid))
            for token in orders.tokens
        ]

    def _moved(self, sample: zenoh.Sample) -> None:
        with suppress(struct.error, IndexError):
            where = place(sample.payload.to_bytes(), self._child)
            with self._lock:
                self._rest.note(where, time.monotonic())

    def _spoken(self, _: zenoh.Sample) -> None:
        with self._lock:
            self._hand_s = time.monotonic()

    def reached(self) -> bool:
        """Whether anybody else is on the bus, by a link of this session's own."""
        info = self._session.info
        return bool(info.peers_zid() or info.routers_zid())

    def over(self, began_s: float) -> bool:
        now_s = time.monotonic()
        with self._lock:
            return self._rest.over(now_s, now_s - began_s)

    def zero(self) -> None:
        """Command it, unless a hand has the sticks."""
        with self._lock:
            hand = time.monotonic() - self._hand_s <= HAND_S
        if not hand:
            self._sent += 1
            told = ATTACHMENT.pack(self._sent, time.time_ns(), len(self._gid), self._gid)
            with suppress(zenoh.ZError):  # the next one may go out
                self._cmd_vel.put(self._zero, attachment=told if self._gid else None)

    def close(self) -> None:
        with suppress(zenoh.ZError):
            self._session.close()


def watch(link: socket.socket, say: Any = print) -> None:
    """One runtime, from its orders to its end. `link`: of messages, SOCK_SEQPACKET."""
    link.settimeout(None)
    told = _received(link)
    if not told or told == BYE:
        return
    try:
        brake = Brake(Orders.read(told))
    except (ValueError, TypeError, KeyError, zenoh.ZError) as error:
        what = " ".join(str(error).split(" at /")[0].split())  # without places in Zenoh's source
        say(f"rfnav guard: cannot guard: {what[:200]}")
        return
    try:
        _guard(link, brake, say)
    finally:
        brake.close()


def _guard(link: socket.socket, brake: Brake, say: Any) -> None:
    moving = ready = False
    while True:
        if not ready and brake.reached():
            ready = True
            with suppress(OSError):
                link.send(READY)
        link.settimeout(SILENCE_S if moving else None if ready else LOOK_S)
        turn = _received(link)
        if turn == BYE:
            return
        if turn in (STILL, MOVING):
            moving = turn == MOVING
            continue
        if moving:
            why = "ended" if turn == b"" else f"gave no sign for {SILENCE_S:g} s"
            say(f"rfnav guard: the control loop {why}: zero is commanded")
            later = _brake(link, brake)
            say(f"rfnav guard: {'it goes on' if later else 'enough of zero'}")
            moving = later == MOVING
            if later == BYE:
                return
        if turn == b"":
            return


def _brake(link: socket.socket, brake: Brake) -> bytes:
    """Zeros, until there is enough of them, or the control loop goes on: what it says then."""
    began_s = time.monotonic()
    link.settimeout(AGAIN_S)
    while not brake.over(began_s):
        brake.zero()
        turn = _received(link)
        if turn in (STILL, MOVING, BYE):
            return turn
        if turn == b"":
            time.sleep(AGAIN_S)
    return b""


def _received(link: socket.socket) -> bytes | None:
    """The next message; b"" when the other side is gone, None when it was silent for too long."""
    try:
        return link.recv(LARGEST)
    except TimeoutError:
        return None
    except OSError:
        return b""


def tell_systemd(state: str) -> None:
    """sd_notify(3), where systemd started the process with Type=notify. Waits for nothing."""
    where = os.environ.get("NOTIFY_SOCKET")
    if where:
        with suppress(OSError), socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as systemd:
            systemd.sendto(state.encode(), socket.MSG_DONTWAIT, where)


def links(path: Path) -> Iterator[socket.socket]:
    """Runtimes that come to a socket, one after the other."""
    path.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
    path.unlink(missing_ok=True)
    with socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET) as door:
        door.bind(str(path))
        path.chmod(0o600)
        door.listen(1)
        tell_systemd("READY=1")
        while True:
            link, _ = door.accept()
            with link:
                yield link


def main(words: Sequence[str] | None = None) -> int:
    """`rfnav guard`."""
    parser = argparse.ArgumentParser("rfnav guard", description=(__doc__ or "").split("\n\n")[0])
    where = parser.add_mutually_exclusive_group(required=True)
    where.add_argument("--socket", type=Path, help="wait there for `rfnav run --guard PATH`")
    where.add_argument("--fd", type=int, help="a runtime's own end, which `rfnav run` passes on")
    asked = parser.parse_args(words)
    # Whoever ends the runtime by its group or its control group does not end what stops the base:
    # this process ends by itself, when the runtime has.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    if asked.fd is not None:
        signal.signal(signal.SIGTERM, signal.SIG_IGN)
    with suppress(OSError):  # where that is not granted, the runtime has said so
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(FIFO_PRIORITY))
    if asked.fd is not None:
        with socket.socket(fileno=asked.fd) as link:
            watch(link, _say)
        return 0
    for link in links(asked.socket):
        watch(link, _say)
    return 0


def _say(line: str) -> None:
    with suppress(OSError):  # nobody reads it any more
        print(line, file=sys.stderr, flush=True)


if __name__ == "__main__":
    sys.exit(main())
