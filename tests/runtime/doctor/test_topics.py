"""Each finding about topics, of hearings made up by hand."""

from dataclasses import replace

import pytest
from hearings import came, healthy

from runtime.config import Config, load
from runtime.doctor.advertised import Advertised
from runtime.doctor.diagnosis import Diagnosis, Grade, fitting
from runtime.doctor.hearing import HeardTopic, Hearing, NetworkHeard
from runtime.doctor.topics import judge_commands, judge_dialect, judge_topics, table
from runtime.robot import wire

CONFIG = Config()


def found(hearing: Hearing, config: Config = CONFIG) -> dict[str, Diagnosis]:
    return {one.about: one for one in judge_topics(hearing, config)}


def without(hearing: Hearing, *names: str) -> Hearing:
    streams = dict(hearing.streams)
    for name in names:
        streams[name] = HeardTopic(streams[name].topic, streams[name].kind)
    return replace(hearing, streams=streams)


def test_a_healthy_robot_is_well_and_what_it_does_not_have_it_does_not_need():
    told = found(healthy(CONFIG))
    assert {one.grade for one in told.values()} == {Grade.OK}
    assert "rgb8 160x120, 10.0 Hz" in told["color"].told
    assert "battery_state (battery)" in told["other senses"].told
    assert told["clocks"].told == "stamps are 10 to 10 ms old when they come"


def test_nothing_at_all_says_what_to_do_first():
    silent = without(healthy(CONFIG), "color", "depth", "camera_info", "odom")
    told = found(replace(silent, network=NetworkHeard()))
    assert told["topics"].grade is Grade.UNKNOWN  # the bus is what is bad
    assert list(told) == ["topics"]
    there = found(silent)["topics"]
    assert there.grade is Grade.BAD
    assert "camera/depth/image_raw" in there.told
    assert "ros2 topic list" in there.remedy


def test_a_robot_in_a_namespace_is_told_by_one_line():
    silent = without(healthy(CONFIG), "color", "depth", "camera_info", "odom")
    there = [Advertised(f"r1/{one.topic}", one.kind, "ros2dds") for one in silent.streams.values()]
    told = found(replace(silent, advertised=there))
    assert fitting(told.values()) == '[bus]\nprefix = "r1"'


def test_a_topic_that_is_called_otherwise_is_named_with_the_line_that_fits():
    there = [Advertised("oak/stereo/depth", wire.IMAGE, "ros2dds")]
    hearing = replace(without(healthy(CONFIG), "depth"), advertised=there)
    told = found(hearing)["depth"]
    assert told.grade is Grade.BAD
    assert told.remedy == 'bus.topics.depth = "oak/stereo/depth"'
    assert told.settings == (("bus.topics.depth", '"oak/stereo/depth"'),)
    assert found(hearing)["color"].grade is Grade.OK


def test_within_a_prefix_the_line_is_without_it():
    config = load(None, ["bus.prefix=r1"])
    there = [Advertised("r1/oak/depth", wire.IMAGE, "ros2dds")]
    told = found(replace(without(healthy(config), "depth"), advertised=there), config)
    assert told["depth"].settings == (("bus.topics.depth", '"oak/depth"'),)


@pytest.mark.parametrize(
    ("there", "words"),
    [
        ([Advertised("camera/depth/image_raw", wire.IMAGE, "ros2dds")], "QoS"),
        ([Advertised("odom", wire.ODOMETRY, "ros2dds")], "start what brings depth"),
        ([], "ros2 topic list"),
    ],
)
def test_a_silent_topic_that_nobody_offers_is_told_with_what_is_known(there: list, words: str):
    told = found(replace(without(healthy(CONFIG), "depth"), advertised=there))["depth"]
    assert told.grade is Grade.BAD
    assert words in told.remedy
    assert not told.settings


def heard(hearing: Hearing, name: str, **how: float) -> Hearing:
    fresh = without(hearing, name)
    came(fresh.streams[name], **how)
    return fresh


@pytest.mark.parametrize(("hz", "grade"), [(8, Grade.OK), (3, Grade.WARNING), (1, Grade.BAD)])
def test_odometry_that_is_seldom_makes_the_robot_slower_and_more_seldom_is_no_use(
    hz: float, grade: Grade
):
    assert found(heard(healthy(CONFIG), "odom", hz=hz))["odom"].grade is grade


def test_a_gap_is_warned_of():
    told = healthy(CONFIG)
    del told.streams["odom"].arrivals[40:50]
    assert found(told)["odom"].grade is Grade.WARNING
    assert "holds the base" in found(told)["odom"].told


def test_depth_is_wanted_more_often_than_colour():
    for name, hz, grade in (("color", 1.6, Grade.OK), ("depth", 1.6, Grade.BAD)):
        assert found(heard(healthy(CONFIG), name, hz=hz))[name].grade is grade


def test_what_cannot_be_read_is_bad_where_nothing_can_and_has_the_decoders_own_remedy():
    hearing = healthy(CONFIG)
    hearing.streams["color"].read = 0
    hearing.streams["color"].bad = 20
    hearing.streams["color"].error = "color: encoding 'bayer': publish rgb8 or bgr8"
    assert found(hearing)["color"].grade is Grade.BAD
    assert found(hearing)["color"].remedy.endswith("publish rgb8 or bgr8")
    hearing.streams["color"].read = 100
    assert found(hearing)["color"].grade is Grade.WARNING


def test_clocks_that_differ_are_told_apart_from_one_that_is_off():
    apart = found(heard(healthy(CONFIG), "odom", hz=20.0, clock_s=-2.0))["clocks"]
    assert apart.grade is Grade.BAD
    assert "odom is stamped 2.00 s before" in apart.told
    far = found(heard(healthy(CONFIG), "odom", hz=20.0, clock_s=-3600.0))["clocks"]
    assert far.grade is Grade.WARNING  # such are related by arrivals
    off = healthy(CONFIG)
    for name, hz in (("color", 10.0), ("depth", 10.0), ("odom", 20.0)):
        off = heard(off, name, hz=hz, clock_s=5.0)
    assert found(off)["clocks"].grade is Grade.WARNING
    assert "ahead of this computer's clock" in found(off)["clocks"].told


def test_stamps_that_stand_still_are_told_of():
    hearing = without(healthy(CONFIG), "odom")
    for one in came(HeardTopic("odom", wire.ODOMETRY), 20.0).arrivals:
        hearing.streams["odom"].came(replace(one, stamp_ns=0))
    hearing.streams["odom"].read = 100
    assert found(hearing)["odom stamps"].grade is Grade.WARNING
    assert found(hearing)["clocks"].grade is Grade.OK


def test_a_sense_that_speaks_nonsense_is_warned_of():
    hearing = healthy(CONFIG)
    came(hearing.streams["battery"], 1.0)
    hearing.streams["battery"].failed(ValueError("percentage 400"))
    told = found(hearing)["battery"]
    assert (told.grade, told.remedy) == (Grade.WARNING, "percentage 400")


def commands(hearing: Hearing, config: Config = CONFIG) -> dict[str, Diagnosis]:
    return {one.about: one for one in judge_commands(hearing, config)}


def test_a_base_that_does_not_listen_is_bad_and_another_commander_is_warned_of():
    hearing = healthy(CONFIG)
    assert commands(hearing)["base"].grade is Grade.OK
    deaf = replace(hearing, network=replace(hearing.network, base=False))
    assert commands(deaf)["base"].grade is Grade.BAD
    driven = replace(hearing, network=replace(hearing.network, commands=5))
    assert commands(driven)["commands"].grade is Grade.WARNING
    ours = replace(driven, network=replace(driven.network, runtime=True))
    assert "commands" not in commands(ours)
    rover = load(None, ["base.kind=mavlink"])
    assert commands(hearing, rover) == {}


@pytest.mark.parametrize(
    ("settings", "there", "fits"),
    [
        ([], Advertised("odom", wire.ODOMETRY, "rmw_zenoh"), ("bus.dialect", '"rmw_zenoh"')),
        ([], Advertised("odom", wire.ODOMETRY, "ros2dds"), None),
        (["bus.dialect=rmw_zenoh"], Advertised("odom", wire.ODOMETRY, "rmw_zenoh"), None),
        (["bus.dialect=rmw_zenoh"], Advertised("odom", wire.ODOMETRY, "ros2dds"),
         ("bus.dialect", '"ros2dds"')),
        (["bus.dialect=rmw_zenoh"], Advertised("odom", wire.ODOMETRY, "rmw_zenoh", domain=7),
         ("bus.domain", "7")),
        (["bus.dialect=rmw_zenoh"], Advertised("odom", wire.ODOMETRY, "rmw_zenoh", hashed=False),
         ("bus.distro", '"humble"')),
        (["bus.dialect=rmw_zenoh", "bus.distro=humble"],
         Advertised("odom", wire.ODOMETRY, "rmw_zenoh"), ("bus.distro", '"jazzy"')),
    ],
)  # fmt: skip
def test_another_dialect_domain_or_distribution_is_told_with_the_line_that_fits(
    settings: list[str], there: Advertised, fits: tuple[str, str] | None
):
    config = load(None, settings)
    (told,) = judge_dialect(replace(healthy(config), advertised=[there]), config)
    assert told.settings == ((fits,) if fits else ())
    assert told.grade is (Grade.BAD if fits else Grade.OK)


def test_where_nobody_tells_nothing_is_said_of_a_dialect():
    ours = Advertised("odom", wire.ODOMETRY, "rmw_zenoh", publishes=False)
    for there in ([], [ours]):
        assert list(judge_dialect(replace(healthy(CONFIG), advertised=there), CONFIG)) == []


def test_a_base_that_wants_stamped_velocities_is_told_by_its_token():
    stamped = Advertised("cmd_vel", wire.TWIST_STAMPED, "ros2dds", publishes=False)
    hearing = replace(healthy(CONFIG), advertised=[stamped])
    told = commands(hearing)["base"]
    assert told.grade is Grade.BAD
    assert told.settings == (("bus.cmd_vel_type", '"TwistStamped"'),)
    config = load(None, ["bus.cmd_vel_type=TwistStamped"])
    assert commands(hearing, config)["base"].grade is Grade.OK


def test_the_table_has_a_row_for_each_topic_that_something_came_on():
    rows = table(healthy(CONFIG), CONFIG)
    assert len(rows) == 5
    assert rows[1].split() == [
        "camera/color/image_raw", "10.0", "0", "ms", "10", "ms", "1000", "rgb8", "160x120",
        "camera_color_optical_frame",
    ]  # fmt: skip
    assert table(Hearing(1.0, {}), CONFIG) == []
