"""The compiled part of images that come packed."""

import numpy as np
from numpy.typing import NDArray

from runtime.core.kernels import _compiled
from runtime.core.types import U8


def unpack_rvl(readings: NDArray[np.uint16], packed: U8) -> bool:
    """Writes all of `readings` (H, W) as RVL has them in `packed` (N,): in turn runs of zeros and
    of others, both told by their length, the others by how they differ from the one before, in
    numbers of nibbles, three bits each, in words of 32 bits. Whether those bytes are so much RVL,
    not less; what is left over is not looked at."""
    return _compiled.unpack_rvl(readings, packed[None])
