"""What a camera tells of itself, as long as it can be read."""

from other_half import camera_info

from runtime.core.types import Intrinsics
from runtime.errors import SensorError
from runtime.robot.camera_info import CameraInfo
from runtime.robot.sync import RawMessage

SIZE, K = (16, 12), (20.0, 20.0, 8.0, 6.0)


def test_of_a_message_that_cannot_be_read_nothing_is_taken():
    told: list[tuple[str, SensorError]] = []
    info = CameraInfo("info", lambda topic, error: told.append((topic, error)))
    info.file(RawMessage(0, camera_info(SIZE, K, frame="/mine"), 0.0))
    assert info.read() == Intrinsics(*K, *SIZE)
    info.file(RawMessage(0, camera_info(SIZE, (0.0, 0.0, 0.0, 0.0), frame="other"), 0.1))
    assert info.read() == Intrinsics(*K, *SIZE)
    assert info.frame == "mine"
    assert [topic for topic, _ in told] == ["info"]
