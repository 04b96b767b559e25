"""Photographs or renderings: what a run's images have looked like so far."""

from dataclasses import dataclass
from typing import Literal

from models.detection.fusion import Domain

MOST = 6.0
"""Log odds that one image may add, either way."""
REMEMBERED = 200
"""Images: what was seen longer ago counts less and less."""
OTHERWISE = 1.0
"""Log odds in the mean from which on the other domain is believed: between them nothing changes."""
SURELY = 6.0
"""Log odds of all images together, without which it is not: one or two unsure images at the start
of a run are not worth half of the detectors."""

DomainSetting = Literal["auto", "photographs", "renderings"]


@dataclass
class DomainEvidence:
    """Mean log odds of the images being photographs, and what follows. With `setting` other than
    "auto" nothing follows from them. Without a detector that can tell, photographs."""

    setting: DomainSetting = "auto"
    log_odds: float = 0.0
    images: int = 0
    believed: Domain = "photographs"

    def __post_init__(self) -> None:
        if self.setting != "auto":
            self.believed = self.setting

    def add(self, log_odds: float | None) -> None:
        """One image's log odds of being a photograph; None where they are not told."""
        if log_odds is None:
            return
        bounded = max(-MOST, min(MOST, log_odds))
        self.images += 1
        self.log_odds += (bounded - self.log_odds) / min(self.images, REMEMBERED)
        if self.setting != "auto":
            return
        together = abs(self.log_odds) * min(self.images, REMEMBERED)
        if abs(self.log_odds) > OTHERWISE and together >= SURELY:
            self.believed = "photographs" if self.log_odds > 0 else "renderings"

    def told(self) -> dict[str, object]:
        """For people: JSON."""
        return {
            "is": self.believed,
            "set": self.setting != "auto",
            "log_odds": round(self.log_odds, 2),
            "images": self.images,
        }
