"""Depth as real cameras give it, by name: `--noise camera=realsense-d435`. All seeded.

Figures are the makers' where they give any, else of the paper named beside them. Shares of lost and
mixed pixels are estimates: no data sheet has them.
"""

import math
from dataclasses import dataclass
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

F32 = NDArray[np.float32]
U8 = NDArray[np.uint8]
Mask = NDArray[np.bool_]

EDGE_RATIO: Final = 0.05
"""A neighbour this much nearer or further, as a share of the distance, is an edge."""
MISSING: Final = 0.002  # of all pixels, whatever they show
GLASS_LOST: Final = 0.9  # of those that show a window or a mirror
PLAIN_LEVELS: Final = 1.5  # deviation of brightness in a window of 9 x 9: no texture to match
WINDOW_PX: Final = 1.5  # sigma of the window that triangulating cameras match, pixels
CORNER_SHARE: Final = 0.3  # of how much deeper a corner is than what surrounds it,
CORNER_M: Final = 0.05  # 5 cm at most: light that came by way of the walls beside it


@dataclass(frozen=True)
class Triangulating:
    """A camera that compares two views, or a view with a pattern that is projected from beside it.

    Disparity, focal_px * baseline_m / z, errs by sigma_px and comes in steps of step_px: depth errs
    by z^2 * sigma_px / (focal_px * baseline_m). `side`: -1 where the second eye is to the right, so
    that what is hidden from it lies to the left of what hides it; 1 where it is to the left.
    `band`: the edge of the image, without a counterpart in the second view, is lost. `plain_m`:
    from there on surfaces without texture begin to be lost.
    """

    near_m: float
    far_m: float
    focal_px: float
    baseline_m: float
    sigma_px: float
    step_px: float
    mixed: float  # share of the pixels at edges that lie between
    side: int
    band: bool = False
    plain_m: float = math.inf


@dataclass(frozen=True)
class TimeOfFlight:
    """A camera that times its own light: error sigma_m where a surface of `reflects` is seen at
    far_m, less with the root of more light; nothing where there is less."""

    near_m: float
    far_m: float
    reflects: float
    sigma_m: float
    mixed: float


DepthCamera = Triangulating | TimeOfFlight
CAMERAS: Final[dict[str, DepthCamera]] = {
    # Structured light. Range: Microsoft, Kinect for Windows, default range. Focal length, baseline,
    # steps of 1/8 px and 4 cm of deviation at 5 m: Khoshelham and Oude Elberink, Sensors 12 (2012).
    "kinect-v1": Triangulating(0.8, 4.0, 580.0, 0.075, 0.07, 1 / 8, mixed=0.4, side=1),
    # Active stereo. Baseline, 87 degrees over 848 pixels, range: Intel, D400 series data sheet
    # (337029). 0.08 px of subpixel error, steps of 1/32 px: Intel's papers on tuning and on
    # subpixel linearity of that series.
    "realsense-d435": Triangulating(
        0.3, 10.0, 447.0, 0.05, 0.08, 1 / 32, mixed=0.6, side=-1, band=True, plain_m=2.5
    ),
    # Time of flight, narrow and unbinned: 0.5 to 3.86 m and 17 mm of deviation down to 15 % of
    # reflection. Microsoft, Azure Kinect DK hardware specifications.
    "azure-kinect": TimeOfFlight(0.5, 3.86, 0.15, 0.017, mixed=0.8),
}


def photograph_depth(
    camera: DepthCamera, depth_m: F32, rgb: U8, glass: Mask, focal_px: float,
    rng: np.random.Generator,
) -> F32:  # fmt: skip
    """(H, W) true depth, m, the colours (H, W, 3) and which pixels show glass, of an image of that
    focal length -> what the camera makes of it; 0 where it has no reading."""
    light = cv2.cvtColor(rgb, cv2.COLOR_RGB2GRAY).astype(np.float32)
    seen = np.where(depth_m > 0, depth_m, np.float32(np.inf))
    read = mixed(depth_m, camera.mixed, rng)
    chance = np.where(glass, np.float32(GLASS_LOST), np.float32(MISSING))
    if isinstance(camera, Triangulating):
        shift_px = np.asarray(focal_px * camera.baseline_m / seen, np.float32)
        read = _matched(read, camera, rng)
        chance[_hidden(shift_px, camera.side)] = 1.0
        if camera.band:
            chance[np.arange(seen.shape[1]) < shift_px] = 1.0
        if math.isfinite(camera.plain_m):
            plain = _deviation(light) < PLAIN_LEVELS
            chance[plain] += np.clip((seen[plain] - camera.plain_m) / camera.plain_m, 0.0, 0.9)
    else:
        # Near infrared: most that is dark to the eye is less so; brightness stands for it as it is.
        enough = camera.reflects / camera.far_m**2
        share = np.maximum(light / np.float32(255), np.float32(0.01)) / seen**2 / enough
        sigma_m = camera.sigma_m / np.sqrt(np.maximum(share, np.float32(1)))
        read += _around_corners(depth_m)
        read += sigma_m * rng.standard_normal(read.shape, np.float32)
        chance[share < 1] = 1.0
    lost = (rng.random(read.shape, np.float32) < chance) | (depth_m <= 0)
    lost |= (read < camera.near_m) | (read > camera.far_m)
    return np.where(lost, np.float32(0), read)


def edges(depth_m: F32) -> Mask:
    """(H, W) m -> pixels with a jump of more than 5 % among their 3 x 3 neighbours."""
    low, high = _range(depth_m)
    found: Mask = high - low > EDGE_RATIO * np.maximum(low, np.float32(0.1))
    return found


def mixed(depth_m: F32, share: float, rng: np.random.Generator) -> F32:
    """(H, W) m -> that share of the pixels at edges reads something between the nearest and the
    farthest of their neighbours."""
    low, high = _range(depth_m)
    flies = edges(depth_m) & (low > 0) & (rng.random(depth_m.shape, np.float32) < share)
    return np.where(flies, low + rng.random(low.shape, np.float32) * (high - low), depth_m)


def _range(depth_m: F32) -> tuple[F32, F32]:
    kernel = np.ones((3, 3), np.uint8)
    return np.asarray(cv2.erode(depth_m, kernel)), np.asarray(cv2.dilate(depth_m, kernel))


def _matched(depth_m: F32, camera: Triangulating, rng: np.random.Generator) -> F32:
    """Depth by way of a disparity that errs alike over a window, and comes in steps."""
    scale = np.float32(camera.focal_px * camera.baseline_m)
    error = cv2.GaussianBlur(rng.standard_normal(depth_m.shape, np.float32), (0, 0), WINDOW_PX)
    sigma_px = camera.sigma_px * 2 * math.sqrt(math.pi) * WINDOW_PX  # what is smoothed errs less
    disparity = scale / np.maximum(depth_m, np.float32(0.1)) + np.float32(sigma_px) * error
    steps = np.maximum(np.round(disparity / camera.step_px), 1) * camera.step_px
    return np.asarray(scale / steps, np.float32)


def _hidden(shift_px: F32, side: int) -> Mask:
    """(H, W) disparities, pixels -> what the second eye cannot see, for something nearer covers it
    there."""
    if side > 0:
        return _hidden(shift_px[:, ::-1], -side)[:, ::-1]
    column = np.arange(shift_px.shape[1], dtype=np.float32) - shift_px
    nearest = np.minimum.accumulate(column[:, ::-1], axis=1)[:, ::-1]
    hidden = np.zeros(shift_px.shape, bool)
    hidden[:, :-1] = column[:, :-1] > nearest[:, 1:]
    return hidden


def _deviation(light: F32) -> F32:
    """(H, W) of brightness, within windows of 9 x 9."""
    mean, square = cv2.blur(light, (9, 9)), cv2.blur(light * light, (9, 9))
    return np.asarray(np.sqrt(np.maximum(square - mean * mean, 0)), np.float32)


def _around_corners(depth_m: F32) -> F32:
    """By how much light that took the longer way, by a surface beside, lengthens depth, m: in
    concave corners."""
    beyond = depth_m - cv2.blur(depth_m, (41, 41))
    return np.asarray(np.clip(CORNER_SHARE * beyond, 0, CORNER_M) * ~edges(depth_m), np.float32)
