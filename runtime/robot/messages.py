"""What came over the wire, as the parts of the runtime tell each other of it."""

from dataclasses import dataclass

from runtime.core.types import Observation
from runtime.robot.sync import Match


@dataclass
class StreamHealth:
    """What came on one topic."""

    received: int = 0
    bad: int = 0
    last_error: str = ""
    blank: int = 0  # depth images without a single reading
    jumped: int = 0  # odometry that is not where the robot can be
    set_back: int = 0  # how often its clock was
    arrival_s: float | None = None  # monotonic, of the newest


@dataclass(frozen=True)
class WireMessage:
    """A message as it came or went; `kind` is its ROS 2 type."""

    topic: str
    kind: str
    payload: bytes


@dataclass(frozen=True)
class ConsumedFrame:
    """An observation as it was handed to the loop, and the messages that it was made of."""

    match: Match
    observation: Observation
    now_s: float
    altered: bool = False  # its images are not those of the messages: turned, straightened, ...
