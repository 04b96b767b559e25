from typing import Any

from numpy.typing import NDArray

from runtime.core.types import F64

def march(
    arrival: F64,
    speed: NDArray[Any],
    cell_m: float,
    limit: float,
    row: int,
    col: int,
    beyond: float,
    /,
) -> float: ...
def descend(arrival: F64, row: int, col: int, limit: int, /) -> bytes: ...
