"""What the robot calls the frames that its odometry and its images are in."""

import threading
from typing import Final

from runtime.errors import SensorError
from runtime.robot.transforms import peek_frame

ODOM: Final = "odom"  # REP 105, where nobody has said otherwise
_HEAD: Final = 300  # bytes of a message, within which its frame stands


class FrameNames:
    """Any thread. The newest message of a stream counts."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._heads: dict[str, bytes] = {}

    def note(self, stream: str, payload: bytes) -> None:
        with self._lock:
            self._heads[stream] = payload[:_HEAD]

    def of(self, stream: str, otherwise: str) -> str:
        """The frame_id of a stream's messages; `otherwise` where there is none."""
        with self._lock:
            head = self._heads.get(stream, b"")
        try:
            return peek_frame(head, stream).lstrip("/") or otherwise
        except SensorError:
            return otherwise
