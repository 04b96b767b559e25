"""How large things look, and how often they stand on the floor: makes `models/words/sizes.toml`.

The size is that of the catalogue's models: the root of the area that a box as wide as deep covers,
seen from a little above. Where things stand is counted in 120 single rooms (`placement_stats.py`).
Run `python -m hil_sim.importers.thing_sizes` after a change of either.
"""

import json
import math
import statistics
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, Final

from hil_sim.scenes.furniture.boxes import furniture
from hil_sim.scenes.generated.placement import TABLE

PATH: Final = Path(__file__).parents[2] / "models" / "words" / "sizes.toml"
ABOVE: Final = 0.3  # of what is flat, the share that is seen from a little above
OTHER: Final = "other"

HEAD = """\
# How large things look, m: the root of the area of their box, seen from a little above; and which
# share of them stands on the floor, where that was counted. This file is made by
# `python -m hil_sim.importers.thing_sizes`.
"""


def looks_m(size_m: tuple[float, float, float]) -> float:
    """Width, depth, height, m -> the root of the area that is seen of such a box, m."""
    side = (size_m[0] + size_m[1]) / 2
    return math.sqrt(side * (size_m[2] + ABOVE * side))


def sizes() -> Iterator[tuple[str, float]]:
    """By category the median of its models."""
    for name, models in sorted(furniture().items()):
        if models and name != OTHER:
            yield name, round(statistics.median(looks_m(model.size_m) for model in models), 2)


def on_floor(rooms: Mapping[str, Any]) -> Iterator[tuple[str, float]]:
    """By category the share that stands on the floor."""
    count: dict[str, float] = {}
    floor: dict[str, float] = {}
    for things in rooms.values():
        for name, thing in things.items():
            many = thing["present"] * thing["mean"]
            count[name] = count.get(name, 0.0) + many * sum(thing.get("on", {}).values())
            floor[name] = floor.get(name, 0.0) + many * thing.get("on", {}).get("floor", 0.0)
    for name in sorted(count):
        if count[name] > 0:
            yield name, round(floor[name] / count[name], 2)


def table() -> str:
    """The file."""
    rooms = json.loads(TABLE.read_text(encoding="utf-8"))["rooms"]
    rows = ["[size_m]", *(f'"{name}" = {m}' for name, m in sizes())]
    rows += ["", "[on_floor]", *(f'"{name}" = {share}' for name, share in on_floor(rooms))]
    return HEAD + "\n" + "\n".join(rows) + "\n"


if __name__ == "__main__":
    PATH.write_text(table(), encoding="utf-8")
