"""CameraInfo -> a lens: pinhole, distortion, and whether that still is in the images."""

import math
from typing import Any, Final

from runtime.core.optics.lens import LEAST_SHARE, Lens, straightened
from runtime.core.optics.registered import resized_intrinsics
from runtime.core.types import Intrinsics
from runtime.errors import SensorError
from runtime.robot import wire
from runtime.robot.bounds import check_camera

BENT: Final = ("plumb_bob", "rational_polynomial", "thin_prism_fringe", "")  # OpenCV's one model,
FISHEYE: Final = ("equidistant", "fisheye", "kannala_brandt")  # and its other
COUNTS: Final = (4, 5, 8, 12, 14)  # of coefficients that the first may have; the second has four
COARSE: Final = 8  # pixels in one, where it is only asked whether a lens can be straightened
REMEDY: Final = "publish rectified images (image_proc: image_rect)"


def is_rectified(topic: str) -> bool:
    """Whether images are without distortion, by the name that image_proc gives them: image_rect,
    image_rect_color, image_rect_raw."""
    return any(part.startswith("image_rect") for part in topic.split("/"))


def decode_lens(payload: bytes, topic: str, rectified: bool = False) -> Lens:
    """CameraInfo -> the lens of images as they are published. `rectified`: they are of its P, and
    without distortion. SensorError for what no camera has."""
    message = wire.decode(payload, wire.CAMERA_INFO, topic)
    p = [float(x) for x in message.p]
    if rectified and p[0] > 0 and p[5] > 0:
        intrinsics = wire.published(message, p[0], p[5], p[2], p[6])
        check_camera(intrinsics, topic)
        return Lens(intrinsics)
    intrinsics = wire.decode_camera_info(payload, topic).value
    return Lens(intrinsics) if rectified else _bent(message, intrinsics, topic)


def _bent(message: Any, intrinsics: Intrinsics, topic: str) -> Lens:
    bent = [float(x) for x in message.d]
    if not any(bent):
        return Lens(intrinsics)
    model = str(message.distortion_model)
    fisheye = model in FISHEYE
    most = 4 if fisheye else COUNTS[-1]
    told = f"{topic}: distortion {model!r} with D = {bent}"
    if not (fisheye or model in BENT) or not all(map(math.isfinite, bent)) or any(bent[most:]):
        known = "plumb_bob, rational_polynomial and equidistant are understood"
        raise SensorError(f"{told}: {known}: else {REMEDY}")
    count = next((n for n in COUNTS if n >= len(bent)), most) if not fisheye else 4
    bent = (bent + [0.0] * count)[:count]
    lens = Lens(intrinsics, tuple(bent), fisheye)
    share = straightened(_coarse(lens)).share
    if share < LEAST_SHARE:
        what = f"straightened, {share:.0%} of the image were seen: calibrate, or {REMEDY}"
        raise SensorError(f"{told}: {what}")
    return lens


def _coarse(lens: Lens) -> Lens:
    """The same view in few pixels: whoever reads a lens is waited for by who drives, and images are
    straightened elsewhere."""
    i = lens.intrinsics
    size = max(COARSE, i.width // COARSE), max(COARSE, i.height // COARSE)
    return Lens(resized_intrinsics(i, *size), lens.coefficients, lens.fisheye)
