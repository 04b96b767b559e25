"""How large things look and where they stand, by name: what a search for them has to see."""

import math
import statistics
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Final

from models.toml_text import read_toml

PATH: Final = Path(__file__).parent / "sizes.toml"
UNKNOWN_M: Final = 0.25
ON_FLOOR: Final = 0.2
SPREAD: Final = 1.5  # times how large it looks: so far may a thing reach from its middle


@dataclass(frozen=True)
class ThingSize:
    """The root of the area of a thing's box, m, which share of such things is on the floor, and how
    far one may reach from its middle, m, inf where nobody knows."""

    size_m: float = UNKNOWN_M
    on_floor: float = ON_FLOOR
    reaches_m: float = math.inf


@cache
def _tables() -> tuple[Mapping[str, float], Mapping[str, float]]:
    table = read_toml(PATH)
    return table["size_m"], table["on_floor"]


def size_of(name: str, others: Iterable[str] = ()) -> ThingSize:
    """Of a thing by its name; of one that is not in the table the median of the `others` that are:
    what is of its kind. UNKNOWN_M, ON_FLOOR where nothing is known."""
    sizes, floors = _tables()
    names = (name,) if name in sizes else tuple(others)
    known = [sizes[other] for other in names if other in sizes]
    stand = [floors[other] for other in names if other in floors]
    return ThingSize(
        statistics.median(known) if known else UNKNOWN_M,
        statistics.median(stand) if stand else ON_FLOOR,
        SPREAD * max(known) if known else math.inf,
    )
