"""What is to be measured of the scene-layout expert."""

from dataclasses import dataclass
from pathlib import Path

KINDS = ("language", "head", "embedding")
"""Of `research.scene_layout`."""


@dataclass(frozen=True)
class ScenePlan:
    """What is measured: `views` of held-out homes, of which `most` a home are drawn, against a
    table of the homes in `counted`, else of the `plans` of so many train homes, which who knows the
    truth has counted, too; a folder of `photographs`, the `sides` of a
    `bank`, where there are any; of each of the `kinds`."""

    views: Path
    counted: Path | None
    most: int
    plans: int
    photographs: Path | None = None
    bank: Path | None = None
    sides: tuple[str, ...] = ()
    kinds: tuple[str, ...] = KINDS
    settings: tuple[str, ...] = ()
    seed: int = 0
