"""What a doctor is told over the bus: messages on what it listens to, and liveliness tokens."""

from answers import refused
from robot_entries import SENSES, STREAMS

from runtime.config import Config
from runtime.doctor.advertised import read_token
from runtime.doctor.camera import judge_camera
from runtime.doctor.hearing import NetworkHeard
from runtime.doctor.odometry import judge_odometry
from runtime.doctor.reading import Reading
from runtime.doctor.topics import judge_topics, table

CONFIG = Config()
TOKENS = (
    "@/aac3/@ros2_lv/MP/oak§rgb§image_raw/sensor_msgs§msg§Image/:::5,10",
    "@ros2_lv/2/aac3/0/10/MP/%/%/talker/%odom/nav_msgs::msg::dds_::Odometry_/RIHS01_0/::,7:,:,:,,",
)
NAMES = [*STREAMS, *SENSES]


def heard(data: bytes) -> None:
    """The first byte says what it is taken for; what is said of it can be printed."""
    if not data:
        return
    number, payload = data[0], data[1:]
    if number >= len(NAMES):
        found = read_token(payload.decode("utf-8", "replace"))
        if found is None:
            refused("no token")
        else:
            assert (found.topic + found.kind).isprintable()
        return
    name = NAMES[number]
    reading = Reading(CONFIG)
    for one in (name, "odom", "camera_info"):
        reading.file(one, payload if one == name else STREAMS[one][0])
    reading.read()
    hearing = reading.hearing()
    hearing.network = NetworkHeard(peers=1)
    if hearing.streams[name].bad:
        refused(hearing.streams[name].error)
    judged = judge_topics, judge_camera, judge_odometry
    told = [one for judge in judged for one in judge(hearing, CONFIG)]
    lines = [*table(hearing, CONFIG), *(text for one in told for text in (one.told, one.remedy))]
    assert all(line.isprintable() for line in lines), lines


def told() -> list[bytes]:
    """Good ones."""
    numbered = [*STREAMS.values(), *SENSES.values()]
    messages = [bytes((n,)) + seed for n, seeds in enumerate(numbered) for seed in seeds]
    return messages + [bytes((len(NAMES),)) + token.encode() for token in TOKENS]
