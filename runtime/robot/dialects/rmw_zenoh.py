"""Native to nodes whose RMW is rmw_zenoh_cpp: the type and its hash are in the key, each message
has an attachment, and endpoints are seen by liveliness tokens.

Formats as of rmw_zenoh_cpp 0.2.4 and 0.1.2 (April and June 2025) and later.
"""

import struct
from collections.abc import Iterator
from typing import Final

from runtime.errors import SensorError
from runtime.robot.dialects.dialect import Qos, Role, RosService, RosTopic
from runtime.robot.dialects.type_hashes import NO_HASH, service_hash, type_hash

NODE: Final = "rfnav"
GID_BYTES: Final = 16
ATTACHMENT: Final = struct.Struct("<qqB16s")  # sequence, ns since 1970, bytes of the gid, the gid
LONGEST: Final = 200  # letters of a name that is told of
_ADMIN: Final = "@ros2_lv"
_SERVICE_QOS: Final = Qos()


class RmwZenoh:
    """A `Dialect`. `prefix`: the robot's ROS namespace; `domain`: ROS_DOMAIN_ID; `distro`: of the
    others; `node`: what they call us."""

    def __init__(self, prefix: str, domain: int, distro: str, node: str = NODE) -> None:
        self._prefix, self._domain = prefix.strip("/"), domain
        self._distro, self._node = distro, node

    def publishes_on(self, topic: RosTopic) -> str:
        return self._key(topic.name, _dds(topic.kind), type_hash(topic.kind, self._distro))

    def listens_on(self, topic: RosTopic) -> str:
        """Whatever its type is: what comes as another is told of, and not only missing."""
        return self._key(topic.name, "*", "*")

    def name_of(self, key: str, topic: RosTopic) -> str:
        before, kind, their_hash = key.rsplit("/", 2)
        name = before.partition("/")[2]
        ours = {_dds(k): type_hash(k, self._distro) for k in topic.kinds}
        if kind not in ours:
            wanted = " or ".join(topic.kinds)
            raise SensorError(
                f"{_shown(name)}: comes as {_shown(_ros(kind))}, where {wanted} is read"
            )
        if their_hash != ours[kind]:
            what = f"{_shown(name)}: comes with {_shown(their_hash)}"
            raise SensorError(f"{what}: {self._other(their_hash)}")
        return name

    def _other(self, their_hash: str) -> str:
        if their_hash == NO_HASH:
            return 'set bus.distro = "humble"'
        if self._distro == "humble":
            return 'set bus.distro = "jazzy", or what the robot has'
        return f"its type is another than that of {self._distro} (bus.distro)"

    def serves_on(self, service: RosService) -> str:
        return self._key(service.name, _dds(service.kind), service_hash(service.kind, self._distro))

    def tokens(
        self, zid: str, numbers: Iterator[int], role: Role, what: RosTopic | RosService
    ) -> tuple[str, ...]:
        if "*" in what.name:
            return ()  # a name that is none cannot be told
        name = _mangled(f"/{self._full(what.name)}")
        if isinstance(what, RosService):
            kinds, qos = [(what.kind, service_hash(what.kind, self._distro))], _SERVICE_QOS
        else:
            kinds = [(kind, type_hash(kind, self._distro)) for kind in what.kinds]
            qos = what.qos
        return tuple(
            f"{self._within(zid)}/{next(numbers)}/{role.value}/{self._place()}/{name}/"
            f"{_dds(kind)}/{hashed}/{_told(qos)}"
            for kind, hashed in kinds
        )

    def node_tokens(self, zid: str) -> tuple[str, ...]:
        return (f"{self._within(zid)}/0/NN/{self._place()}",)

    def attachment(self, sequence: int, now_ns: int, gid: bytes) -> bytes | None:
        return ATTACHMENT.pack(sequence, now_ns, GID_BYTES, gid)

    def reply_attachment(self, request: bytes | None, now_ns: int) -> bytes | None:
        """A reply is told by the request's own number and asker."""
        if request is None or len(request) != ATTACHMENT.size:
            return None
        sequence, _, _, gid = ATTACHMENT.unpack(request)
        return ATTACHMENT.pack(sequence, now_ns, GID_BYTES, gid)

    def _key(self, name: str, kind: str, hashed: str) -> str:
        return f"{self._domain}/{self._full(name)}/{kind}/{hashed}"

    def _full(self, name: str) -> str:
        return "/".join(part for part in (self._prefix, name.strip("/")) if part)

    def _within(self, zid: str) -> str:
        return f"{_ADMIN}/{self._domain}/{zid}/0"

    def _place(self) -> str:
        """Enclave, which is none, namespace and name of the node."""
        return f"%/{_mangled(f'/{self._prefix}')}/{self._node}"


def _told(qos: Qos) -> str:
    """Reliability, durability, history, and that the rest is as by default; so is what is empty."""
    reliability, durability = "" if qos.reliable else "2", "1" if qos.latched else ""
    return f"{reliability}:{durability}:,{qos.depth}:,:,:,,"


def _mangled(name: str) -> str:
    return name.replace("/", "%")


def _dds(kind: str) -> str:
    """`sensor_msgs/msg/Image` -> `sensor_msgs::msg::dds_::Image_`."""
    package, folder, name = kind.split("/")
    return f"{package}::{folder}::dds_::{name}_"


def _shown(name: str) -> str:
    """What came, in a line."""
    return name if name.isprintable() and len(name) < LONGEST else f"{name!r:.{LONGEST}}"


def _ros(dds: str) -> str:
    """The other way round, of whatever came."""
    return dds.replace("::dds_::", "::").replace("::", "/").removesuffix("_")
