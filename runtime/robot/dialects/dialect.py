"""What a dialect of ROS 2 over Zenoh is to the runtime: names, and what goes along with messages.

A dialect is text and bytes alone; the Zenoh session is `ros_node.RosNode`'s.
"""

from collections.abc import Iterator
from dataclasses import dataclass, field
from enum import Enum
from typing import Protocol


@dataclass(frozen=True)
class Qos:
    """Quality of service by ROS 2's policies: reliable or best effort; `latched`: transient local,
    who joins late gets the last; `depth`: how many are kept."""

    reliable: bool = True
    latched: bool = False
    depth: int = 10


@dataclass(frozen=True)
class RosTopic:
    """Messages of one ROS 2 type (`pkg/msg/Name`), or of one of two. `name`: below the robot's
    namespace, without leading slash; one that is listened to may have Zenoh's wildcards."""

    name: str
    kind: str
    qos: Qos = field(default_factory=Qos)
    other_kind: str = ""

    @property
    def kinds(self) -> tuple[str, ...]:
        return (self.kind, self.other_kind) if self.other_kind else (self.kind,)


@dataclass(frozen=True)
class RosService:
    """Requests and replies of one ROS 2 type: `pkg/srv/Name`, or of an action `pkg/action/Name_X`
    (X: SendGoal, GetResult)."""

    name: str
    kind: str


class Role(Enum):
    """What an endpoint is, by the two letters of its liveliness token."""

    PUBLISHER = "MP"
    SUBSCRIPTION = "MS"
    SERVICE = "SS"


class Dialect(Protocol):
    """Key expressions of topics and services, and what else the others go by. `zid`: the session's
    id; `numbers`: of endpoints in their node, one for each that is told of."""

    def publishes_on(self, topic: RosTopic) -> str: ...

    def listens_on(self, topic: RosTopic) -> str: ...

    def name_of(self, key: str, topic: RosTopic) -> str:
        """The name of the topic, with the namespace, that a message came on. SensorError, with what
        to do, for one that is of another type."""
        ...

    def serves_on(self, service: RosService) -> str: ...

    def tokens(
        self, zid: str, numbers: Iterator[int], role: Role, what: RosTopic | RosService
    ) -> tuple[str, ...]:
        """Liveliness tokens by which the others see an endpoint; () where they go by none."""
        ...

    def node_tokens(self, zid: str) -> tuple[str, ...]:
        """The same of the node itself."""
        ...

    def attachment(self, sequence: int, now_ns: int, gid: bytes) -> bytes | None:
        """What goes with a publication. `gid`: (16,) the publisher's."""
        ...

    def reply_attachment(self, request: bytes | None, now_ns: int) -> bytes | None:
        """What goes with the reply to a request that came with `request`."""
        ...
