"""What is still a sensor's message: sizes before it is kept, values when it is read."""

from collections.abc import Iterable
from typing import Final

from runtime.core.types import Intrinsics
from runtime.errors import SensorError

NAME: Final = 200  # letters of a frame's
MOST_PIXELS: Final = 16_000_000  # a size field beyond this is damage, not a camera
IMAGE_BYTES: Final = 4 * MOST_PIXELS + 4096
OTHER_BYTES: Final = 1 << 17  # of a message that is no image: tf of a humanoid has 20,000
FARTHEST_M: Final = 1e5  # from where odometry began
ANYWHERE_M: Final = 1e8  # from the origin of a frame that may be in another country
SIDE_PX: Final = (8, 8192)  # of an image
FOCAL: Final = (0.1, 50.0)  # in widths and heights of its image: 157 degrees to 1
MIDDLE: Final = (-1.0, 2.0)  # of the optical axis, the same


def check_bytes(payload: bytes, topic: str, image: bool = False) -> None:
    """SensorError for a message larger than any that is one: it is not kept."""
    most = IMAGE_BYTES if image else OTHER_BYTES
    if len(payload) > most:
        raise SensorError(f"{topic}: {len(payload)} bytes: at most {most} are taken")


def check_frame(name: str, topic: str) -> str:
    """A frame's name, which is told in lines. SensorError for one that is not fit for that."""
    if len(name) > NAME or not name.isprintable():
        what = f"a frame of {len(name)} letters" if len(name) > NAME else f"the frame {name!r}"
        raise SensorError(f"{topic}: {what}: name it by at most {NAME} that can be printed")
    return name


def check_camera(intrinsics: Intrinsics, topic: str) -> None:
    """SensorError for intrinsics that no camera has."""
    i, remedy = intrinsics, "publish the size and K that it was calibrated for"
    size = f"{topic}: an image of {i.width}x{i.height}"
    if not all_within(SIDE_PX, (i.width, i.height)):
        raise SensorError(f"{size}, must be {SIDE_PX[0]} to {SIDE_PX[1]} wide and high: {remedy}")
    focal, middle = (i.fx / i.width, i.fy / i.height), (i.cx / i.width, i.cy / i.height)
    if not (all_within(FOCAL, focal) and all_within(MIDDLE, middle)):
        what = f"fx {i.fx:g}, fy {i.fy:g}, cx {i.cx:g}, cy {i.cy:g}"
        raise SensorError(f"{size} with {what} is of no camera: {remedy}")


def check_size(shape: tuple[int, ...], topic: str, intrinsics: Intrinsics, info_topic: str) -> None:
    """Raise SensorError when an image's (H, W) contradicts the intrinsics."""
    height, width = shape[:2]
    if (width, height) != (intrinsics.width, intrinsics.height):
        raise SensorError(
            f"{topic}: image is {width}x{height} but {info_topic} describes "
            f"{intrinsics.width}x{intrinsics.height}: publish depth registered to colour "
            "(align_depth) and the camera_info of that size"
        )


def all_within(bounds: tuple[float, float], values: Iterable[float]) -> bool:
    """Also false for what is not a number."""
    return all(bounds[0] <= value <= bounds[1] for value in values)
