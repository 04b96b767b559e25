"""Generated train homes that the experts have learned of: whoever is judged there is not asked what
he does not know."""

from collections.abc import Iterable
from typing import Final

from runtime.errors import RfNavError

COUNTED: Final = range(900_000, 901_000)
"""Seeds of what `hil-sim counts` counts."""
TAUGHT: Final = range(200_000, 201_000)
"""Seeds of the views that the scene-layout expert is trained on, and of plans that are counted to
compare it with."""


def check_unknown(names: Iterable[str], known: Iterable[range] = (COUNTED, TAUGHT)) -> None:
    """RfNavError for the first of these homes that is among the known."""
    every = tuple(known)
    for name in names:
        split, _, seed = name.partition("-")
        if split == "train" and seed.isdecimal() and any(int(seed) in seeds for seeds in every):
            raise RfNavError(
                f"{name}: what is judged has learned of this home; take seeds from which it has not"
            )
