"""The runtime's side of its watchdog (`runtime/guard.py`): starts it, tells it of every turn of the
control loop, and starts another when it is gone."""

import itertools
import secrets
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Sequence
from contextlib import ExitStack, suppress
from pathlib import Path
from typing import Final, Self

from runtime import guard
from runtime.errors import BusError
from runtime.log import say
from runtime.robot import wire
from runtime.robot.dialects.choice import spoken
from runtime.robot.dialects.dialect import Role
from runtime.robot.dialects.rmw_zenoh import GID_BYTES
from runtime.robot.heard_topics import heard_topics
from runtime.robot.publications import cmd_vel_topic
from runtime.robot.session import BusConfig, session_settings

END_S: Final = 2.0  # how long a guard may take to end, or one that waits somewhere to answer
# Waited before the first, second, ... guard after one that is gone; then no other is started.
AGAIN_S: Final = (0.5, 1.0, 2.0, 4.0, 8.0, 16.0, 32.0, 60.0)
SETTLED_S: Final = 60.0  # one that was there for so long was a good one: what comes counts anew
LINK_BYTES: Final = 16_384  # holds the turns of about two seconds
UNREAD: Final = 20  # turns in a row that a full link did not take: who should read them hangs
HANGS: Final = "the guard does not read what it is told"
GUARD_NODE: Final = "rfnav_guard"  # what others call it


class Pulse:
    """`path`: where a guard waits that somebody else has started; else one is started here, and
    ends after this process. BusError when there is none at `path`. When a guard is gone, `tell` is
    told of it and another takes its place, after `again_s[n]` the n-th time in a row."""

    def __init__(
        self,
        config: BusConfig,
        path: Path | None = None,
        tell: Callable[[str], None] = say,
        again_s: Sequence[float] = AGAIN_S,
    ) -> None:
        self._orders, self._path = orders(config).told(), path
        self._tell, self._again_s = tell, again_s
        self._process: subprocess.Popen[bytes] | None = None
        self._changed = threading.Condition()
        self._closed, self._moving = False, False
        self._ready, self._unread = False, 0
        self._lost = ""  # why there is no guard
        self._link: socket.socket | None = self._opened()
        self._keeper = threading.Thread(target=self._keep, name="guard", daemon=True)
        self._keeper.start()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def beat(self, moving: bool) -> str:
        """A turn of the control loop, in its own thread: whether the base was told to move. Why
        nobody guards it, "" when somebody does. Waits for nothing."""
        with self._changed:
            self._moving = moving
            link = self._link
            if link is None:
                return self._lost
            try:
                self._send(link, guard.MOVING if moving else guard.STILL)
                if not self._ready:
                    self._hear(link)
            except OSError as error:
                self._lose(f"the guard is gone ({error.strerror})")
            return self._lost or self._lacks()

    def close(self) -> None:
        """After zero was commanded. The guard may go; where the last turn left the base moving, as
        after a fault, it commands zero itself, for that one zero may have been lost. Idempotent."""
        with self._changed:
            if self._closed:
                return
            self._closed = True
            link, self._link = self._link, None
            self._changed.notify_all()
        self._keeper.join(END_S + 1.0)
        if link is None:
            self._reap()
            return
        with link:
            if self._moving:
                return  # it sees that the link ends, brakes, and ends itself
            with suppress(OSError):
                link.settimeout(END_S)
                link.send(guard.BYE)
        self._reap(END_S)

    # -- inside, holding `_changed` ----------------------------------------------------------------

    def _send(self, link: socket.socket, turn: bytes) -> None:
        try:
            link.send(turn)
            self._unread = 0
        except BlockingIOError:  # it has not read what was sent, which tells it enough
            self._unread += 1
            # One that somebody else started cannot be killed: it would find the end of its link
            # when it goes on, and command zero to a base that is driven.
            if self._path is None and self._lacks() == HANGS:
                self._lose(HANGS)

    def _lacks(self) -> str:
        """Why a guard that has a link does not guard; "" when it does."""
        if not self._ready:
            return "the guard reaches nobody"
        return HANGS if self._unread >= UNREAD else ""

    def _hear(self, link: socket.socket) -> None:
        with suppress(BlockingIOError):  # it is not ready yet
            self._ready = link.recv(guard.LARGEST) == guard.READY
            if not self._ready:
                self._lose("the guard has ended")

    def _lose(self, why: str) -> None:
        if self._link is not None:
            self._link.close()
        self._link, self._lost = None, why
        self._changed.notify_all()

    # -- the thread that keeps a guard there -------------------------------------------------------

    def _keep(self) -> None:
        tried, began_s = 0, time.monotonic()
        while True:
            with self._changed:
                self._changed.wait_for(lambda: self._closed or self._link is None)
                if self._closed:
                    return
                why = self._lost
            self._reap()
            tried = 0 if time.monotonic() - began_s >= SETTLED_S else tried
            if tried == len(self._again_s):
                self._tell(
                    f"{why} once more: no other is started; see to it, then start rfnav anew"
                )
                return
            wait_s = self._again_s[tried]
            self._tell(f"{why}: nobody watches over control; another try in {wait_s:g} s")
            with self._changed:
                if self._changed.wait_for(lambda: self._closed, wait_s):
                    return
            tried, began_s = tried + 1, time.monotonic()
            self._again()

    def _again(self) -> None:
        link, lost = None, ""
        try:
            link = self._opened()
        except (BusError, OSError) as error:
            lost = f"the guard cannot be started ({error})"
        with self._changed:
            if self._closed:
                if link is not None:
                    link.close()
                return
            self._link, self._lost, self._ready, self._unread = link, lost, False, 0

    def _opened(self) -> socket.socket:
        """A link to a guard that has its orders, unless it is gone already, which the next turn
        tells."""
        link = self._started() if self._path is None else _connected(self._path)
        link.settimeout(END_S)
        with suppress(OSError):
            link.send(self._orders)
        link.setblocking(False)
        return link

    def _started(self) -> socket.socket:
        ours, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        ours.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, LINK_BYTES)
        with theirs, ExitStack() as undone:
            undone.callback(ours.close)
            self._process = subprocess.Popen(
                [sys.executable, "-m", guard.__name__, "--fd", str(theirs.fileno())],
                stdin=subprocess.DEVNULL,
                pass_fds=(theirs.fileno(),),
                start_new_session=True,  # what ends our group does not end it
            )
            undone.pop_all()
        return ours

    def _reap(self, patience_s: float = 0.0) -> None:
        """The process that was started is over, at the latest after that time."""
        process, self._process = self._process, None
        if process is None:
            return
        try:
            process.wait(patience_s)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()


def orders(config: BusConfig) -> guard.Orders:
    """What the guard of a bus is to do. It goes where the runtime goes; where that only listens, it
    listens at the port after, for the runtime's own may be gone when it is needed."""
    topics = config.topics
    zero = wire.encode_twist(0.0, 0.0)
    if config.cmd_vel_type == "TwistStamped":
        zero = wire.encode_twist_stamped(0.0, 0.0, 0, config.cmd_vel_frame)
    settings = session_settings(config)
    doors = [end for name, end in config.endpoints if name == "bus.listen"]
    settings["listen/endpoints"] = [] if config.connect else [_beside(end) for end in doors]
    dialect, heard, cmd_vel = (
        spoken(config, GUARD_NODE),
        heard_topics(config),
        cmd_vel_topic(config),
    )
    gid = secrets.token_bytes(GID_BYTES)
    numbers = itertools.count(1)
    tokens = (
        *dialect.node_tokens(guard.ZID),
        *dialect.tokens(guard.ZID, numbers, Role.PUBLISHER, cmd_vel),
        *dialect.tokens(guard.ZID, numbers, Role.SUBSCRIPTION, heard["odom"]),
    )
    return guard.Orders(
        settings,
        dialect.publishes_on(cmd_vel),
        zero.hex(),
        dialect.publishes_on(heard["odom"]),
        dialect.listens_on(heard["teleop"]) if topics.teleop else "",
        not topics.pose,
        gid.hex() if dialect.attachment(1, 0, gid) else "",
        list(tokens),
    )


def _beside(endpoint: str) -> str:
    """The next port: where the runtime's own is a door, its guard needs one of its own."""
    where, _, port = endpoint.rpartition(":")
    return f"{where}:{int(port) + 1}"


def _connected(path: Path) -> socket.socket:
    link = socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET)
    link.settimeout(END_S)
    try:
        link.connect(str(path))
    except OSError as error:
        link.close()
        what = f"{path}: no guard waits there ({error.strerror or error})"
        raise BusError(f"{what}: start `rfnav guard --socket {path}`") from error
    link.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, LINK_BYTES)
    return link
