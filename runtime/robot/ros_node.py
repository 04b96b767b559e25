"""What the runtime is among the nodes of ROS 2: topics, services, and what the others see of it, on
one Zenoh session and in one dialect."""

import hashlib
import itertools
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Final

import zenoh
from zenoh.ext import (
    CacheConfig,
    HistoryConfig,
    MissDetectionConfig,
    declare_advanced_publisher,
    declare_advanced_subscriber,
)

from runtime.errors import BusError, SensorError
from runtime.robot.dialects.dialect import Dialect, Role, RosService, RosTopic
from runtime.robot.dialects.rmw_zenoh import GID_BYTES

HEARTBEAT_S: Final = 0.5  # after which who missed the last of a latched topic is told so


@dataclass(frozen=True)
class Sending:
    """How a publisher's messages go out: `urgent` ones before others; `blocks`: a link that is full
    is waited for, else what does not fit is dropped, but what `put` says `waits`, which only one
    may that `may_wait`."""

    urgent: bool = False
    blocks: bool = False
    may_wait: bool = False


class Publisher:
    """One topic's. Any thread may publish."""

    def __init__(
        self, declared: Any, waiting: Any, name: str, dialect: Dialect, gid: bytes
    ) -> None:
        self._declared, self._waiting, self._name = declared, waiting, name
        self._dialect, self._gid = dialect, gid
        self._numbers = itertools.count(1)

    def put(self, payload: bytes, waits: bool = False) -> None:
        """BusError when the session is closed."""
        goes_along = self._dialect.attachment(next(self._numbers), time.time_ns(), self._gid)
        try:
            (self._waiting if waits else self._declared).put(payload, attachment=goes_along)
        except zenoh.ZError as error:
            raise BusError(f"{self._name}: cannot be published: {error}") from error

    def heard(self) -> bool:
        """Whether anybody listens, as far as this session knows. To what is latched somebody may
        come later."""
        status = getattr(self._declared, "matching_status", None)
        return status is None or bool(status.matching)


class ServiceCall:
    """A request that came, and its reply: the first counts, one to a caller that has gone is lost
    quietly. Any thread may reply."""

    def __init__(self, query: Any, key: str, dialect: Dialect) -> None:
        self._query, self._key, self._dialect = query, key, dialect
        self._lock = threading.Lock()
        self.payload: bytes = query.payload.to_bytes() if query.payload is not None else b""

    def reply(self, payload: bytes) -> None:
        query = self._take()
        if query is None:
            return
        came = query.attachment.to_bytes() if query.attachment is not None else None
        goes_along = self._dialect.reply_attachment(came, time.time_ns())
        try:
            query.reply(self._key, payload, attachment=goes_along)
        except zenoh.ZError:
            pass  # the session that asked has closed
        finally:
            query.drop()

    def drop(self) -> None:
        """It is not answered."""
        query = self._take()
        if query is not None:
            query.drop()

    def _take(self) -> Any:
        with self._lock:
            query, self._query = self._query, None
        return query


class RosNode:
    """See the module. `strange`: told of messages on a topic that are of another type than is read
    there, by the topic's name, in Zenoh's threads."""

    def __init__(
        self,
        session: Any,
        dialect: Dialect,
        strange: Callable[[str, SensorError], None] = lambda name, error: None,
    ) -> None:
        self._session, self._dialect, self._strange = session, dialect, strange
        self._zid, self._numbers = str(session.zid()), itertools.count(1)
        self._declared: list[Any] = []
        self._tell(dialect.node_tokens(self._zid))

    def subscribe(
        self,
        topic: RosTopic,
        receive: Callable[[str, bytes], None],
        strange: Callable[[], None] = lambda: None,
    ) -> None:
        """`receive` is called in Zenoh's threads, with the topic's name and CDR; `strange` instead
        of it, after the node's own, for a message of another type. What was published before comes
        too where the topic is latched and its publisher keeps it."""

        def hear(sample: zenoh.Sample) -> None:
            try:
                name = self._dialect.name_of(str(sample.key_expr), topic)
            except SensorError as error:
                self._strange(topic.name, error)
                strange()
                return
            receive(name, sample.payload.to_bytes())

        key = self._dialect.listens_on(topic)
        if topic.qos.latched:
            history = HistoryConfig(detect_late_publishers=True, max_samples=topic.qos.depth)
            subscriber = declare_advanced_subscriber(self._session, key, hear, history=history)
        else:
            subscriber = self._session.declare_subscriber(key, hear)
        self._declared.append(subscriber)
        self._see(Role.SUBSCRIPTION, topic)

    def publisher(self, topic: RosTopic, sending: Sending) -> Publisher:
        """Undeclared with the node."""
        key, congestion = self._dialect.publishes_on(topic), zenoh.CongestionControl
        how: Any = {
            "congestion_control": congestion.BLOCK if sending.blocks else congestion.DROP,
            "priority": zenoh.Priority.INTERACTIVE_HIGH if sending.urgent else zenoh.Priority.DATA,
            "express": True,
        }
        if topic.qos.latched:
            heartbeat = MissDetectionConfig(heartbeat=None, sporadic_heartbeat=HEARTBEAT_S)
            how |= {"cache": CacheConfig(topic.qos.depth), "publisher_detection": True}
            declared = declare_advanced_publisher(
                self._session, key, sample_miss_detection=heartbeat, **how
            )
        else:
            declared = self._session.declare_publisher(key, **how)
        self._declared.append(declared)
        waiting = declared
        if sending.may_wait and not sending.blocks:
            how["congestion_control"] = congestion.BLOCK
            waiting = self._session.declare_publisher(key, **how)
            self._declared.append(waiting)
        seen_as = self._see(Role.PUBLISHER, topic) or f"{self._zid}/{key}"
        gid = hashlib.blake2b(seen_as.encode(), digest_size=GID_BYTES).digest()
        return Publisher(declared, waiting, topic.name, self._dialect, gid)

    def serve(self, service: RosService, answer: Callable[[ServiceCall], None]) -> None:
        """`answer` is called in Zenoh's threads; whoever owns them replies from another."""
        key = self._dialect.serves_on(service)

        def receive(query: zenoh.Query) -> None:
            answer(ServiceCall(query, key, self._dialect))

        self._declared.append(self._session.declare_queryable(key, receive, complete=True))
        self._see(Role.SERVICE, service)

    def close(self) -> None:
        """Undeclare everything. Idempotent."""
        declared, self._declared = self._declared, []
        for one in reversed(declared):
            one.undeclare()

    def _see(self, role: Role, what: RosTopic | RosService) -> str:
        """Have the others see an endpoint; by which token, "" where they go by none."""
        tokens = self._dialect.tokens(self._zid, self._numbers, role, what)
        self._tell(tokens)
        return tokens[0] if tokens else ""

    def _tell(self, tokens: tuple[str, ...]) -> None:
        for token in tokens:
            self._declared.append(self._session.liveliness().declare_token(token))
