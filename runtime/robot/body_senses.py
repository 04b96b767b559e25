"""What a robot says of its body: bumper, cliff sensors, wheels, battery, and whether a hand is on
the sticks. Each is used where somebody publishes it; filed in the threads of the bus, read by any.
"""

import math
import threading
from collections.abc import Callable
from dataclasses import replace
from typing import Final

from runtime.clock import Clock
from runtime.core.motion.contact import AHEAD_RAD, NOTHING, Contact, Felt, Touch
from runtime.errors import SensorError
from runtime.record import Record, unrecorded
from runtime.robot import wire_senses
from runtime.robot.battery import Charge
from runtime.robot.bounds import check_bytes
from runtime.robot.session import SensesConfig, TopicsConfig
from runtime.robot.streams import StreamHealth, WireMessage
from runtime.robot.wire_senses import HazardKind

HAND_S: Final = 0.5  # after what a hand said last, as in `twist_mux` set-ups
CHARGING_S: Final = 15.0  # for so long it is believed to charge; drivers tell every few seconds
WATCH_S: Final = 0.15  # after what a cliff sensor said last, it does not watch any more
TOLD_S: Final = 2.0  # how long a contact that is over is told of: many ticks
SENSORS: Final = 64  # on one robot; more names are somebody's mistake
_TOUCHES: Final = {
    HazardKind.BUMP: Touch.BUMPER,
    HazardKind.CLIFF: Touch.CLIFF,
    HazardKind.WHEEL_DROP: Touch.WHEEL,
}


class BodySenses:
    """See the module. `topics`: by sense, where it is listened for."""

    def __init__(
        self,
        topics: TopicsConfig,
        config: SensesConfig,
        clock: Clock,
        record: Record = unrecorded,
    ) -> None:
        self._config, self._clock, self._record = config, clock, record
        self._lock = threading.Lock()
        senses = ("teleop", "battery", "bumper", "cliff", "hazards")
        self.topics = {name: t for name in senses if (t := getattr(topics, name))}
        self._read: dict[str, Callable[[bytes, str, float], str]] = {
            "teleop": self._sticks,
            "battery": self._charge,
            "bumper": self._bump,
            "cliff": self._look_down,
            "hazards": self._hazards,
        }
        self._health: dict[str, StreamHealth] = {}  # of topics on which something came
        self._contacts: dict[str, Contact] = {}  # by sensor
        self._newest_s = -math.inf  # when the last contact began
        self._cliffs: dict[str, tuple[float, float]] = {}  # by topic: bearing, when it spoke last
        self._hand: tuple[str, float] = ("", -math.inf)  # who spoke, and when
        self._charged = Charge()
        self._charging_s = -math.inf  # when it said so last, if nothing else since
        self._of_hundred = False  # the battery tells percent, and not shares

    # -- in the bus's threads ------------------------------------------------------------------

    def file(self, sense: str, topic: str, payload: bytes) -> None:
        """Take in a message on a topic of a sense."""
        now_s = self._clock.now_s()
        with self._lock:
            if topic not in self._health and len(self._health) >= SENSORS:
                topic = self.topics[sense]  # a wildcard's: nobody has so many
            health = self._health.setdefault(topic, StreamHealth())
            health.received += 1
            health.arrival_s = now_s
            if sense == "teleop":  # a hand, even where what it says cannot be read
                self._hand = topic, now_s
            try:
                check_bytes(payload, topic)
                kind = self._read[sense](payload, topic, now_s)
            except SensorError as error:
                health.bad += 1
                health.last_error = str(error)
                return
        self._record("wire", WireMessage(topic, kind, payload))

    # -- what is asked -------------------------------------------------------------------------

    def felt(self) -> Felt:
        """What the body feels now, and what it felt within TOLD_S."""
        with self._lock:
            now_s = self._clock.now_s()
            watched = self._watched(now_s)
            if not self._contacts and not watched:
                return NOTHING
            fresh = [c for c in self._contacts.values() if c.held or now_s - c.since_s <= TOLD_S]
            return Felt(tuple(sorted(fresh, key=lambda c: (c.since_s, c.sensor))), watched)

    def hand(self) -> str:
        """Who has the sticks; "" when nobody."""
        with self._lock:
            who, spoke_s = self._hand
            return who if self._clock.now_s() - spoke_s <= HAND_S else ""

    def battery_percent(self) -> float | None:
        """0 to 100; None where that is not known."""
        with self._lock:
            return self._charged.percent(self._clock.now_s())

    def charging(self) -> bool:
        """Whether the battery has said lately that it charges."""
        with self._lock:
            return self._clock.now_s() - self._charging_s <= CHARGING_S

    def health(self) -> dict[str, StreamHealth]:
        """By topic, of those on which something came."""
        with self._lock:
            return {topic: replace(health) for topic, health in self._health.items()}

    def _watched(self, now_s: float) -> bool:
        """Holding the lock: whether the end of the floor would be felt. One sensor that has fallen
        silent may be the one above it; what looks down behind does not tell of what is ahead."""
        ahead = any(abs(bearing) <= AHEAD_RAD for bearing, _ in self._cliffs.values())
        return ahead and all(now_s - spoke_s <= WATCH_S for _, spoke_s in self._cliffs.values())

    # -- inside, holding the lock; each returns the message's type -------------------------------

    def _sticks(self, payload: bytes, topic: str, now_s: float) -> str:
        return wire_senses.check_sticks(payload, topic)

    def _charge(self, payload: bytes, topic: str, now_s: float) -> str:
        told = wire_senses.decode_battery(payload, topic).value
        # The standard has 0 to 1, but many drivers tell percent: one that does is known by it.
        self._of_hundred |= told is not None and told > 1
        charges = wire_senses.decode_charging(payload, topic)
        self._charging_s = now_s if charges else -math.inf
        self._charged.tell(told if told is None or self._of_hundred else 100 * told, now_s)
        return wire_senses.BATTERY_STATE

    def _bump(self, payload: bytes, topic: str, now_s: float) -> str:
        self._feel(
            Touch.BUMPER, topic, _last(topic), wire_senses.decode_flag(payload, topic), now_s
        )
        return wire_senses.BOOL

    def _look_down(self, payload: bytes, topic: str, now_s: float) -> str:
        below_m = wire_senses.decode_range(payload, topic).value
        if topic in self._cliffs or len(self._cliffs) < SENSORS:
            self._cliffs[topic] = wire_senses.bearing_named(_last(topic)), now_s
        none = below_m > self._config.cliff_m
        self._feel(Touch.CLIFF, topic, f"cliff {_last(topic)}", none, now_s)
        return wire_senses.RANGE

    def _hazards(self, payload: bytes, topic: str, now_s: float) -> str:
        found = wire_senses.decode_hazards(payload, topic).value
        self._cliffs[topic] = 0.0, now_s  # all that lasts is told every time, or that nothing does
        lasting = {(_TOUCHES[h.kind], h.sensor) for h in found if h.kind in _TOUCHES}
        for touch, sensor in sorted(lasting):
            self._feel(touch, topic, sensor or touch.value, True, now_s)
        told = {f"{topic} {touch.value} {sensor or touch.value}" for touch, sensor in lasting}
        for key, contact in self._contacts.items():
            if key.startswith(f"{topic} ") and key not in told:
                self._contacts[key] = replace(contact, held=False)
        return wire_senses.HAZARDS

    def _feel(self, touch: Touch, topic: str, sensor: str, held: bool, now_s: float) -> None:
        key = f"{topic} {touch.value} {sensor}"
        before = self._contacts.get(key)
        if before is not None and (before.held or not held):
            self._contacts[key] = replace(before, held=held)
        elif held:
            if before is None and len(self._contacts) >= SENSORS:
                raise SensorError(f"{topic}: {sensor}: more than {SENSORS} sensors on one robot")
            # Whoever looks at what is new goes by when it began: no two begin together.
            began_s = self._newest_s = max(now_s, math.nextafter(self._newest_s, math.inf))
            bearing = wire_senses.bearing_named(sensor)
            self._contacts[key] = Contact(touch, sensor, bearing, began_s, True)


def _last(topic: str) -> str:
    return topic.rpartition("/")[2]
