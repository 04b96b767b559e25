"""A recorded drive, as what the robot published."""

import json
from collections.abc import Iterator
from pathlib import Path

from runtime.bench.synthetic import Published
from runtime.errors import RecordingError
from runtime.recording.messages import LOOP, color_topic, depth_topic, slashed
from runtime.recording.reader import messages
from runtime.robot.session import TopicsConfig
from runtime.robot.transforms import TF, TF_STATIC


def goal_of(path: Path) -> str:
    """What was looked for first; RecordingError when nothing was."""
    for message in messages(path):
        if message.topic == f"{LOOP}request":
            request = json.loads(message.payload)
            if request["kind"] == "goal":
                return str(request["body"]["goal"])
    raise RecordingError(f"{path}: nothing was looked for in it: give --goal")


def topics_of(topics: TopicsConfig) -> dict[str, str]:
    """Where what is in a recording is published: colour is compressed in it, depth is not."""
    odometry = topics.pose or topics.odom
    images = (color_topic(topics), depth_topic(topics))
    names = (topics.camera_info, odometry, TF, TF_STATIC)
    return {slashed(name): name for name in names} | {name: name.lstrip("/") for name in images}


def camera_of(topics: TopicsConfig) -> tuple[str, ...]:
    """Settings that read a recording's images, whatever the camera's own came as."""
    return (
        f"bus.topics.color={color_topic(topics).lstrip('/')}",
        f"bus.topics.depth={depth_topic(topics).lstrip('/')}",
        "bus.compressed=[]",
        "camera.depth_unit_m=0.0",
        "camera.depth_nothing_m=0.0",
    )


def drive(path: Path, topics: TopicsConfig, seconds: float) -> Iterator[Published]:
    """The first so many seconds of what came of the robot, in the order in which it was written.
    RecordingError for a recording without colour: the detectors would have nothing to do; and for
    one whose images are not as they came, which its CameraInfo is not of."""
    _check_as_came(path)
    names, first_ns, coloured = topics_of(topics), None, False
    for message in messages(path):
        if message.topic not in names:
            continue
        first_ns = message.log_time_ns if first_ns is None else first_ns
        if message.log_time_ns - first_ns > seconds * 1e9:
            break
        coloured |= message.topic == color_topic(topics)
        yield Published(names[message.topic], message.log_time_ns, message.payload)
    if not coloured:
        raise RecordingError(f"{path}: has no colour images: the detectors have nothing to look at")


def _check_as_came(path: Path) -> None:
    """By the first frame: it is the same of all."""
    frame = next((m for m in messages(path) if m.topic == f"{LOOP}frame"), None)
    if frame is not None and json.loads(frame.payload).get("altered"):
        raise RecordingError(
            f"{path}: its images were set upright, straightened or put into colour's pixels, and "
            "would be once more: bench a drive of another camera, or none"
        )
