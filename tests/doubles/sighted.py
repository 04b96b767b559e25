"""What a keyframe shows toward a frontier, made up."""

import numpy as np

from runtime.core.types import Sight


def sight(column: float, range_m: float = 2.0, mark: int = 0) -> Sight:
    """Of a made-up detector that tells 3 numbers of 2 by 4 parts, all of another value."""
    features = np.arange(mark, mark + 24, dtype=np.float16).reshape(3, 2, 4)
    return Sight(features, np.linspace(0, 1, 16).astype(np.float16).reshape(2, 2, 4), column,
                 range_m)  # fmt: skip
