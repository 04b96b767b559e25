"""What others publish, by the liveliness tokens that the bridge and rmw_zenoh declare: nothing has
to be subscribed for that, which would have a bridge carry it all."""

import difflib
from collections.abc import Collection, Iterable
from dataclasses import dataclass, replace
from typing import Final

from runtime.robot.dialects.type_hashes import NO_HASH

BRIDGE, RMW = "ros2dds", "rmw_zenoh"
TOKENS: Final = {BRIDGE: "@/*/@ros2_lv/**", RMW: "@ros2_lv/**"}  # what is asked for
_ROLES: Final = {"MP": True, "MS": False}  # whether it publishes, or listens
_BRIDGE_PARTS: Final = 7  # @/<zid>/@ros2_lv/MP/<key>/<type>/<qos>
_RMW_PARTS: Final = 13  # @ros2_lv/<domain>/<zid>/<node>/<id>/MP/<enclave>/<ns>/<name>/<topic>/...
# What a name is likely, and surely not, the topic of.
_LIKELY: Final = {
    "color": ("color", "colour", "rgb", "image_raw"),
    "depth": ("depth", "aligned", "registered"),
    "camera_info": ("color", "colour", "rgb"),
    "odom": ("odom",),
}
_NEVER: Final = {
    "color": ("depth", "infra", "/ir/", "disparity", "stereo", "mask", "confidence"),
    "camera_info": ("depth", "infra", "/ir/", "stereo"),
}
_DIGITS, _LETTERS = 6, 500  # that a domain, and a name with its type, have at most
_MUST: Final = {"depth": ("depth", "disparity", "stereo")}


@dataclass(frozen=True)
class Advertised:
    """Somebody publishes `kind`, a ROS 2 type, on `topic`, without leading slash, or listens for
    it there. By rmw_zenoh also: in which ROS domain, and whether types have hashes."""

    topic: str
    kind: str
    dialect: str
    publishes: bool = True
    domain: int = 0
    hashed: bool = True


def read_token(key: str) -> Advertised | None:
    """A liveliness token's key; None for one that is of something else, or of nothing known."""
    parts = key.split("/")
    if len(parts) == _BRIDGE_PARTS and parts[0] == "@" and parts[3] in _ROLES:
        topic, kind = (part.replace("§", "/") for part in parts[4:6])
        return _told(Advertised(topic, kind, BRIDGE, _ROLES[parts[3]]))
    if len(parts) == _RMW_PARTS and parts[0] == "@ros2_lv" and parts[5] in _ROLES:
        topic, kind, domain = parts[9].replace("%", "/"), parts[10], parts[1]
        kind = kind.replace("::dds_::", "/").replace("::", "/").rstrip("_")
        if domain.isascii() and domain.isdecimal() and len(domain) <= _DIGITS:
            told = Advertised(topic, kind, RMW, _ROLES[parts[5]], int(domain), parts[11] != NO_HASH)
            return _told(told)
    return None


def _told(one: Advertised) -> Advertised | None:
    """Printable, and of a sane length: it goes to a terminal, and into a configuration."""
    one = replace(one, topic=one.topic.strip("/"))
    words = one.topic + one.kind
    sane = one.topic and words.isprintable() and len(words) < _LETTERS
    return one if sane and '"' not in words and "\\" not in words else None


def instead(
    stream: str,
    topic: str,
    kinds: Collection[str],
    advertised: Iterable[Advertised],
    taken: Collection[str],
) -> list[str]:
    """Topics of the right type that could be meant in place of `topic`, the likeliest first."""
    names = {one.topic for one in advertised if one.publishes and one.kind in kinds}
    names -= {t.strip("/") for t in taken}
    fitting = [
        name
        for name in names
        if not any(word in name.lower() for word in _NEVER.get(stream, ()))
        and (stream not in _MUST or any(word in name.lower() for word in _MUST[stream]))
    ]

    def likeness(name: str) -> tuple[float, str]:
        words = sum(word in name.lower() for word in _LIKELY.get(stream, ()))
        same = difflib.SequenceMatcher(None, name, topic.strip("/")).ratio()
        return -(words + same), name

    return sorted(fitting, key=likeness)


def prefix_of(topics: Iterable[str], advertised: Iterable[Advertised]) -> str:
    """The namespace under which all of these topics are advertised; "" where there is none."""
    names = [one.topic for one in advertised if one.publishes]
    found: set[str] | None = None
    for topic in topics:
        end = "/" + topic.strip("/")
        prefixes = {name.removesuffix(end) for name in names if name.endswith(end)}
        found = prefixes if found is None else found & prefixes
    return min(found, default="") if found else ""
