"""What a rendered thing is made of, at random: fabric, wood, marble, paint. Else a detector takes
any light fabric for a bed."""

import math
import random

import cv2
import numpy as np
from numpy.typing import NDArray

GRAIN_PX = (3.0, 60.0)
"""Finest and coarsest grain, drawn along and across: alike they make spots, unlike wood."""
STRENGTH, TINT = (0.1, 0.5), (0.55, 1.45)


def patterned(
    rng: random.Random, rgb: NDArray[np.uint8], things: NDArray[np.int32], share: float
) -> NDArray[np.uint8]:
    """A frame (H, W, 3) in which a `share` of the `things` (H, W), object numbers or -1, have a
    pattern and a colour of their own; light and shade stay."""
    out = rgb.copy()
    for thing in np.unique(things[things >= 0]):
        if rng.random() < share:
            rows, columns = np.nonzero(things == thing)
            shape = np.ptp(rows) + 1, np.ptp(columns) + 1
            factors = _pattern(rng, *map(int, shape))
            painted = rgb[rows, columns] * factors[rows - rows.min(), columns - columns.min()]
            out[rows, columns] = painted.clip(0, 255).astype(np.uint8)
    return out


def _pattern(rng: random.Random, height: int, width: int) -> NDArray[np.float32]:
    """(height, width, 3) factors of the colours: a tint, and grain in two sizes."""
    noise = np.random.default_rng(rng.getrandbits(32))
    grain = np.zeros((height, width), np.float32)
    low, high = (math.log(px) for px in GRAIN_PX)
    across, along = np.exp(noise.uniform(low, high, 2))
    for finer in (1, 3):
        cells = (int(height * finer / across) + 2, int(width * finer / along) + 2)
        coarse = noise.standard_normal(cells).astype(np.float32) / finer
        grain += cv2.resize(coarse, (width, height), interpolation=cv2.INTER_CUBIC)
    colour = noise.uniform(*STRENGTH) * noise.uniform(0.3, 1.0, 3)
    tint = noise.uniform(*TINT) * noise.uniform(0.8, 1.2, 3)
    return np.asarray(tint * (1 + grain[..., None] * colour).clip(0.2), np.float32)
