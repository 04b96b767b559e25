"""What a body says, as it comes: contacts that begin and end, sticks, a battery."""

import math

import pytest
from manual_clock import ManualClock
from other_half import battery_state, flag, hazards

from runtime.config import RealtimeConfig
from runtime.core.motion.contact import NOTHING, Touch
from runtime.core.motion.velocity_policy import FELT_S
from runtime.robot import wire, wire_senses
from runtime.robot.battery import UNSURE_S
from runtime.robot.body_senses import CHARGING_S, HAND_S, SENSORS, TOLD_S, WATCH_S, BodySenses
from runtime.robot.session import SensesConfig, TopicsConfig

NAMES = TopicsConfig()


class Body(BodySenses):
    """With a clock that is set by hand, and what was told to a recorder."""

    def __init__(self, topics: TopicsConfig = NAMES) -> None:
        self.clock, self.told = ManualClock(100.0), []
        note = lambda kind, value: self.told.append(value.kind)  # noqa: E731
        super().__init__(topics, SensesConfig(), self.clock, note)

    def says(self, sense: str, payload: bytes, topic: str = "") -> None:
        self.file(sense, topic or getattr(NAMES, sense), payload)

    def held(self) -> dict[str, bool]:
        return {contact.sensor: contact.held for contact in self.felt().contacts}


def under(metres: float) -> bytes:
    return wire_senses.encode_range(metres, 1, 0.5, "cliff")


def test_of_a_body_that_says_nothing_nothing_is_known():
    body = Body()
    assert body.felt() is NOTHING
    assert body.hand() == ""
    assert body.battery_percent() is None
    assert body.health() == {}


def test_a_bumper_is_touched_and_let_go_and_told_of_for_a_while():
    body = Body()
    body.says("bumper", flag(False))
    assert body.felt().contacts == ()
    body.says("bumper", flag(True))
    (contact,) = body.felt().contacts
    assert (contact.touch, contact.bearing_rad, contact.since_s) == (Touch.BUMPER, 0.0, 100.0)
    body.clock.advance(1.0)
    body.says("bumper", flag(True))  # it still is: no other contact
    assert body.felt().contacts == (contact,)
    body.says("bumper", flag(False))
    assert body.held() == {"bumper": False}
    body.clock.advance(TOLD_S)
    assert body.felt().contacts == ()
    body.says("bumper", flag(True))
    assert body.felt().contacts[0].since_s > contact.since_s


def test_a_touch_between_two_looks_is_not_lost():
    body = Body()
    for value in (True, False, True, False):
        body.says("bumper", flag(value))
    (contact,) = body.felt().contacts
    assert not contact.held
    assert contact.since_s > 100.0  # two that came at one moment are told apart


def test_cliff_sensors_by_their_topics():
    body = Body()
    body.says("cliff", under(0.03), "robot/cliff/front_left")
    assert body.felt().contacts == ()
    assert body.felt().cliffs_watched
    body.says("cliff", under(0.3), "robot/cliff/front_left")
    body.says("cliff", under(0.02), "robot/cliff/front_right")
    (contact,) = body.felt().contacts
    assert (contact.touch, contact.sensor) == (Touch.CLIFF, "cliff front_left")
    assert contact.bearing_rad > 0
    body.clock.advance(WATCH_S + 0.01)
    assert not body.felt().cliffs_watched


def test_cliffs_are_watched_only_while_every_sensor_speaks():
    body = Body()
    body.says("cliff", under(0.03), "cliff/front_left")
    body.says("cliff", under(0.03), "cliff/front_right")
    assert body.felt().cliffs_watched
    for _ in range(2):
        body.clock.advance(WATCH_S * 0.75)
        body.says("cliff", under(0.03), "cliff/front_left")
    assert not body.felt().cliffs_watched
    body.says("cliff", under(0.03), "cliff/front_right")
    assert body.felt().cliffs_watched


def test_a_cliff_sensor_behind_does_not_watch_the_way_ahead():
    body = Body()
    body.says("cliff", under(0.03), "cliff/rear_left")
    assert not body.felt().cliffs_watched
    body.says("cliff", under(0.03), "cliff/left")
    assert body.felt().cliffs_watched


def test_a_sensor_is_felt_within_what_the_speed_over_unseen_floor_allows():
    assert WATCH_S + 1 / RealtimeConfig().control_hz <= FELT_S + 1e-9


def test_a_create_tells_of_all_at_once():
    body = Body()
    body.says("hazards", hazards([("bump_left", 1), ("wheel_drop_left", 4)], 1))
    assert body.held() == {"bump_left": True, "wheel_drop_left": True}
    body.says("hazards", hazards([("bump_left", 1), ("base_link", 0), ("base_link", 3)], 2))
    assert body.held() == {"bump_left": True, "wheel_drop_left": False}
    body.says("hazards", hazards([], 3))
    assert not any(body.held().values())
    assert body.felt().cliffs_watched


def test_any_word_is_a_hand_and_half_a_second_later_there_is_none():
    body = Body()
    body.says("teleop", wire.encode_twist(0.0, 0.0))  # it says: stand still
    assert body.hand() == "cmd_vel_teleop"
    body.clock.advance(HAND_S)
    assert body.hand() == "cmd_vel_teleop"
    body.clock.advance(0.001)
    assert body.hand() == ""
    body.says("teleop", b"what is this")  # whatever it says: somebody has the sticks
    assert body.hand() == "cmd_vel_teleop"
    health = body.health()["cmd_vel_teleop"]
    assert (health.received, health.bad) == (2, 1)
    assert "cmd_vel_teleop: 12 bytes are not a CDR" in health.last_error


def test_a_driver_that_begins_with_0_is_believed_when_it_stays_so():
    body = Body()
    body.says("battery", battery_state(0.0, 1))
    assert body.battery_percent() is None
    body.clock.advance(UNSURE_S)
    assert body.battery_percent() == 0.0


@pytest.mark.parametrize(
    ("told", "percent"),
    [([0.5], 50.0), ([1.0], 100.0), ([80.0], 80.0), ([55.0, 0.9], 0.9), ([0.3, math.nan], None)],
)
def test_a_battery_tells_shares_or_percent(told: list[float], percent: float | None):
    body = Body()
    for share in told:
        body.says("battery", battery_state(share, 1))
    assert body.battery_percent() == (None if percent is None else pytest.approx(percent))


def test_a_battery_charges_as_long_as_it_says_so():
    body = Body()
    assert not body.charging()
    body.says("battery", battery_state(0.5, 1, charging=True))
    assert body.charging()
    body.clock.advance(CHARGING_S + 0.1)
    assert not body.charging()
    body.says("battery", battery_state(math.nan, 2, charging=True))  # whatever is in it
    assert body.charging()
    body.says("battery", battery_state(0.5, 3))
    assert not body.charging()


def test_what_cannot_be_read_is_counted_and_not_recorded():
    body = Body()
    for sense in body.topics:
        body.says(sense, b"\0\1\0\0rubbish")
    assert {topic: health.bad for topic, health in body.health().items()} == dict.fromkeys(
        (NAMES.teleop, NAMES.battery, NAMES.bumper, NAMES.cliff, NAMES.hazards), 1
    )
    assert body.told == []
    body.says("bumper", flag(True))
    assert body.told == [wire_senses.BOOL]


def test_a_robot_has_no_more_sensors_than_robots_have():
    body = Body()
    for n in range(SENSORS + 5):
        body.says("cliff", under(0.3), f"cliff/{n}")
    assert len(body.felt().contacts) == SENSORS
    health = body.health()
    assert len(health) == SENSORS + 1
    assert sum(one.received for one in health.values()) == SENSORS + 5
    assert health["cliff/*"].bad == 5


def test_a_topic_without_a_name_is_not_listened_to():
    assert "teleop" not in Body(TopicsConfig(teleop="")).topics
