"""What setting images right costs a frame: `python -m runtime.bench.optics`."""

from collections.abc import Callable, Iterator
from typing import Final

import cv2
import numpy as np

from runtime.bench.own_time import print_stages
from runtime.core.mapping.floor_plane import MISTAKEN, floor_seen
from runtime.core.mapping.solid_depth import solid
from runtime.core.optics.lens import Lens, straightened
from runtime.core.optics.registered import Extrinsics, registered, resized
from runtime.core.types import Intrinsics, Mount

CAMERA: Final = Intrinsics(388.0, 388.0, 320.0, 240.0, 640, 480)
BENT: Final = (-0.25, 0.06, 0.001, 0.0, 0.0)


def stages() -> Iterator[tuple[str, Callable[[], object]]]:
    """What may be done to an image of 640 x 480."""
    rng = np.random.default_rng(0)
    rgb = rng.integers(0, 255, (480, 640, 3), dtype=np.uint8)
    rows = np.arange(480)[:, None] + np.zeros(640)
    floor = np.where(rows > 250, 0.88 * 388 / np.maximum(1.0, rows - 239.5), 4.0)
    depth = (floor + 0.004 * floor**2 * rng.standard_normal(floor.shape)).astype(np.float32)
    turned, bent = straightened(Lens(CAMERA), 1), straightened(Lens(CAMERA, BENT), 1)
    beside = np.eye(4)
    beside[:3, 3] = 0.06, 0.0, 0.0
    yield "turned by 90 degrees: colour", lambda: turned.color(rgb)
    yield "turned by 90 degrees: depth", lambda: turned.depth(depth)
    yield "bent (and turned): colour", lambda: bent.color(rgb)
    yield "bent (and turned): depth", lambda: bent.depth(depth)
    placed = Extrinsics.of(beside)
    yield "registered to colour", lambda: registered(depth, Lens(CAMERA), placed, CAMERA)
    small = np.ascontiguousarray(depth[::2, ::2])
    yield "of half the size", lambda: resized(solid(small), 640, 480)
    mount = Mount()
    yield "the floor, by a mistaken mount", lambda: floor_seen(depth, CAMERA, mount, MISTAKEN)


if __name__ == "__main__":
    cv2.setNumThreads(1)
    print_stages(stages())
