"""Behind `zenoh-bridge-ros2dds`: a topic is its name, a message its CDR, and no more."""

from collections.abc import Iterator

from runtime.robot.dialects.dialect import Role, RosService, RosTopic


class Ros2dds:
    """A `Dialect`. `prefix`: the robot's ROS namespace."""

    def __init__(self, prefix: str) -> None:
        self._prefix = prefix.strip("/")

    def publishes_on(self, topic: RosTopic) -> str:
        return self._key(topic.name)

    def listens_on(self, topic: RosTopic) -> str:
        return self._key(topic.name)

    def name_of(self, key: str, topic: RosTopic) -> str:
        return key

    def serves_on(self, service: RosService) -> str:
        return self._key(service.name)

    def tokens(
        self, zid: str, numbers: Iterator[int], role: Role, what: RosTopic | RosService
    ) -> tuple[str, ...]:
        return ()

    def node_tokens(self, zid: str) -> tuple[str, ...]:
        return ()

    def attachment(self, sequence: int, now_ns: int, gid: bytes) -> bytes | None:
        return None

    def reply_attachment(self, request: bytes | None, now_ns: int) -> bytes | None:
        return None

    def _key(self, name: str) -> str:
        return "/".join(part for part in (self._prefix, name.strip("/")) if part)
