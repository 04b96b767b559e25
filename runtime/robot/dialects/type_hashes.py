"""Hashes of ROS 2 types (REP 2011, RIHS01), by which nodes of rmw_zenoh know that they mean the
same type. Humble has none."""

from functools import cache
from typing import Any, Final

from rosbags.interfaces import Nodetype
from rosbags.typesys import Stores, get_typestore

from runtime.robot import wire

NO_HASH: Final = "TypeHashNotSupported"  # what Humble's rmw_zenoh says in place of one
_EVENT_INFO: Final = "service_msgs/msg/ServiceEventInfo"
# rosbags has its `char[16]` as it is written; ROS 2 makes bytes of chars before it hashes.
_AS_HASHED: Final = (Nodetype.ARRAY, ((Nodetype.BASE, ("uint8", 0)), 16))


@cache
def type_hash(kind: str, distro: str) -> str:
    """Of a message's type, which `wire.STORE` knows."""
    return NO_HASH if distro == "humble" else str(_store(distro, kind).hash_rihs01(kind))


@cache
def service_hash(kind: str, distro: str) -> str:
    """Of a service's type, `KIND_Request` and `KIND_Response` of which `wire.STORE` knows. It is
    that of a type with both in it, and with what tells of a call, since Iron."""
    if distro == "humble":
        return NO_HASH
    request, response, event = f"{kind}_Request", f"{kind}_Response", f"{kind}_Event"
    store = _store(distro, request, response)
    made: Any = {
        event: (
            [],
            [
                ("info", (Nodetype.NAME, _EVENT_INFO)),
                ("request", (Nodetype.SEQUENCE, ((Nodetype.NAME, request), 1))),
                ("response", (Nodetype.SEQUENCE, ((Nodetype.NAME, response), 1))),
            ],
        ),
        kind: (
            [],
            [
                ("request_message", (Nodetype.NAME, request)),
                ("response_message", (Nodetype.NAME, response)),
                ("event_message", (Nodetype.NAME, event)),
            ],
        ),
    }
    store.register(made)
    return str(store.hash_rihs01(kind))


def _store(distro: str, *kinds: str) -> Any:
    """A distribution's types, and those of ours that it does not bring."""
    store = _known(distro)
    if any(kind not in store.fielddefs for kind in kinds):
        ours = wire.STORE.fielddefs
        store.register({kind: ours[kind] for kind in ours.keys() - store.fielddefs.keys()})
    return store


@cache
def _known(distro: str) -> Any:
    store: Any = get_typestore(Stores[f"ROS2_{distro.upper()}"])
    constants, fields = store.fielddefs[_EVENT_INFO]
    told = [(name, _AS_HASHED if name == "client_gid" else what) for name, what in fields]
    store.fielddefs[_EVENT_INFO] = (constants, told)
    return store
