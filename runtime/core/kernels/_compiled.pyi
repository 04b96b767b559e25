from typing import Any

from numpy.typing import NDArray

from runtime.core.types import F64

def march(arrival: F64, speed: NDArray[Any], cell_m: float, limit: float, /) -> None: ...
