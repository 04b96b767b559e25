"""Against hashes that ROS 2's own packages carry (Jazzy's `share/**/*.json`), and those that its
documentation shows of `ros2 action info --verbose`."""

import pytest

from runtime.robot import drawn_messages, wire, wire_senses
from runtime.robot.action_types import CANCEL, STATUS, ActionType
from runtime.robot.diagnostics import DIAGNOSTICS
from runtime.robot.dialects.type_hashes import NO_HASH, service_hash, type_hash

KNOWN = {
    wire.IMAGE: "d31d41a9a4c4bc8eae9be757b0beed306564f7526c88ea6a4588fb9582527d47",
    wire.COMPRESSED_IMAGE: "15640771531571185e2efc8a100baf923961a4d15d5569652e6cb6691e8e371a",
    wire.CAMERA_INFO: "b3dfd68ff46c9d56c80fd3bd4ed22c7a4ddce8c8348f2f59c299e73118e7e275",
    wire.ODOMETRY: "3cc97dc7fb7502f8714462c526d369e35b603cfc34d946e3f2eda2766dfec6e0",
    wire.POSE_STAMPED: "10f3786d7d40fd2b54367835614bff85d4ad3b5dab62bf8bca0cc232d73b4cd8",
    wire.STRING: "df668c740482bbd48fb39d76a70dfd4bd59db1288021743503259e948f6b1a18",
    wire.TWIST: "9c45bf16fe0983d80e3cfe750d6835843d265a9a6c46bd2e609fcddde6fb8d2a",
    wire.TWIST_STAMPED: "5f0fcd4f81d5d06ad9b4c4c63e3ea51b82d6ae4d0558f1d475229b1121db6f64",
    wire.TF_MESSAGE: "e369d0f05a23ae52508854b66f6aa0437f3449d652e8cbf22d5abe85d020f087",
    wire_senses.LASER_SCAN: "64c191398013af96509d518dac71d5164f9382553fce5c1f8cca5be7924bd828",
    wire_senses.BATTERY_STATE: "4bee5dfce981c98faa6828b868307a0a73f992ed0789f374ee96c8f840e69741",
    wire_senses.RANGE: "b42b62562e93cbfe9d42b82fe5994dfa3d63d7d5c90a317981703f7388adff3a",
    wire_senses.BOOL: "feb91e995ff9ebd09c0cb3d2aed18b11077585839fb5db80193b62d74528f6c9",
    drawn_messages.OCCUPANCY_GRID: (
        "8d348150c12913a31ee0ec170fbf25089e4745d17035792a1ba94d6f0bc0cfc7"
    ),
    drawn_messages.PATH: "1957a5bb3cee5da65c4e52e52b65a93df227efce4c20f8458b36e73066ca334b",
    drawn_messages.MARKERS: "86cb8800b6fb05b5eff1abd7a56f62a5641d3ae9a1c29e78e67e704f1d067dcf",
    DIAGNOSTICS: "5a8a36efb05fb25070fa0fb3810290c0e6cd4862b54a8fb975a1ee8dc55a333e",
    STATUS: "6c1684b00f177d37438febe6e709fc4e2b0d4248dca4854946f9ed8b30cda83e",
}
ROTATE = ActionType.define(
    "turtlesim_msgs/action/RotateAbsolute", "float32 theta", "float32 delta", "float32 remaining"
)
SERVICES = {
    CANCEL: "573d8b0a534451d7bc2ac8c5ffde8ac14b8593b7001175d0cd6516dcbeb8689a",
    f"{ROTATE.kind}_SendGoal": "3d5d3cfcbb721f88038eaedcd4af95565360a82b36f1983e3a6c7448d2d18fbe",
    f"{ROTATE.kind}_GetResult": "f96fd02477be2a47122fca142e960d407b24850c6eac72047872ba764473c4ef",
}
FEEDBACK = "bef10993e1ee82b35f99f7e390bac1e6cc64e2a3090536887832e122aa71f1b5"


@pytest.mark.parametrize(("kind", "known"), KNOWN.items())
@pytest.mark.parametrize("distro", ["jazzy", "kilted", "lyrical"])
def test_a_messages_hash_is_the_one_that_its_package_has(kind: str, known: str, distro: str):
    assert type_hash(kind, distro) == f"RIHS01_{known}"


@pytest.mark.parametrize(("kind", "known"), SERVICES.items())
def test_a_services_hash_is_that_of_request_response_and_event(kind: str, known: str):
    assert service_hash(kind, "jazzy") == f"RIHS01_{known}"


def test_the_parts_of_an_action_have_theirs():
    assert type_hash(f"{ROTATE.kind}_FeedbackMessage", "jazzy") == f"RIHS01_{FEEDBACK}"


def test_types_that_no_distribution_brings_have_hashes_and_humble_has_none():
    assert type_hash(wire_senses.HAZARDS, "jazzy").startswith("RIHS01_")
    assert type_hash(drawn_messages.DETECTIONS, "lyrical").startswith("RIHS01_")
    assert type_hash(wire.IMAGE, "humble") == NO_HASH
    assert service_hash(CANCEL, "humble") == NO_HASH
