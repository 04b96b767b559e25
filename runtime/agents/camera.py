"""One image of the robot's camera, as it comes."""

import queue
from contextlib import closing, suppress
from typing import Any, Final

import cv2

from runtime.errors import BusError
from runtime.robot.dialects.choice import spoken
from runtime.robot.heard_topics import heard_topics
from runtime.robot.images.reading import decode_color
from runtime.robot.ros_node import RosNode
from runtime.robot.session import BusConfig
from runtime.view.pictures import smaller

IMAGE: Final = "color"
NODE: Final = "rfnav_mcp"
QUALITY: Final = 70
WITHIN_S: Final = 3.0


def camera_jpeg(session: Any, bus: BusConfig) -> bytes:
    """The next colour image, its longer side at most 640 px; BusError when none comes, SensorError
    for one that cannot be read."""
    topic = heard_topics(bus)[IMAGE]
    came: queue.Queue[bytes] = queue.Queue(1)

    def receive(_: str, payload: bytes) -> None:
        with suppress(queue.Full):
            came.put_nowait(payload)

    node = RosNode(session, spoken(bus, NODE))
    with closing(node):
        node.subscribe(topic, receive)
        try:
            payload = came.get(timeout=WITHIN_S)
        except queue.Empty:
            raise BusError(f"{topic.name}: no image came within {WITHIN_S:g} s") from None
    image = smaller(decode_color(payload, topic.name, bus.is_packed(IMAGE)).value)
    done, jpeg = cv2.imencode(
        ".jpg", cv2.cvtColor(image, cv2.COLOR_RGB2BGR), [cv2.IMWRITE_JPEG_QUALITY, QUALITY]
    )
    assert done
    return jpeg.tobytes()
