"""Where to look closely: at what stands on tables, not at walls and floors."""

import numpy as np
import pytest

from runtime.core.objects.surfaces import SHARE, STRIDE, surfaces_window
from runtime.core.types import Intrinsics, Mount, Observation, Pose

WIDTH, HEIGHT = 320, 240
CAMERA = Intrinsics(200.0, 200.0, WIDTH / 2, HEIGHT / 2, WIDTH, HEIGHT)
MOUNT = Mount(z_m=1.0)
WALL_M = 4.0


def view(*tables: tuple[float, float, float, float, float]) -> Observation:
    """Floor, a wall, and table tops: from and to ahead, from and to on the right, height; m."""
    v, u = np.mgrid[:HEIGHT, :WIDTH].astype(np.float64)
    right, down = (u + 0.5 - CAMERA.cx) / CAMERA.fx, (v + 0.5 - CAMERA.cy) / CAMERA.fy
    with np.errstate(divide="ignore"):
        depth = np.minimum(np.where(down > 0, MOUNT.z_m / down, np.inf), WALL_M)
        for near, far, left, to, high in tables:
            at = np.where(down > 0, (MOUNT.z_m - high) / down, np.inf)
            on = (at > near) & (at < far) & (at * right > left) & (at * right < to)
            depth = np.where(on & (at < depth), at, depth)
    rgb = np.zeros((HEIGHT, WIDTH, 3), np.uint8)
    return Observation(0, rgb, depth.astype(np.float32), Pose(0.0, 0.0, 0.0), CAMERA)


@pytest.mark.parametrize(("left", "to", "side"), [(-1.4, -0.3, "left"), (0.3, 1.4, "right")])
def test_the_window_is_where_the_table_is(left: float, to: float, side: str) -> None:
    window = surfaces_window(view((1.2, 2.2, left, to, 0.75)), MOUNT)
    assert window is not None
    x0, y0, x1, y1 = window
    assert (x1 - x0, y1 - y0) == pytest.approx((SHARE * WIDTH, SHARE * HEIGHT), abs=STRIDE)
    assert 0 <= x0 < x1 <= WIDTH
    assert 0 <= y0 < y1 <= HEIGHT
    assert (x0 + x1 < WIDTH) == (side == "left")
    # what stands on it is in the window: 20 cm above its middle
    u = CAMERA.cx + CAMERA.fx * (left + to) / 2 / 1.7
    v = CAMERA.cy + CAMERA.fy * (1.0 - 0.95) / 1.7
    assert x0 <= u <= x1
    assert y0 <= v <= y1


def test_floor_and_walls_are_not_worth_it() -> None:
    assert surfaces_window(view(), MOUNT) is None
    far = view((3.6, 3.9, -1.0, 1.0, 0.75))
    assert surfaces_window(far, MOUNT) is None


def test_without_depth_there_is_none() -> None:
    for value in (0.0, np.nan, np.inf):
        seen = view()
        seen.depth_m[:] = value
        assert surfaces_window(seen, MOUNT) is None
