"""When a battery is too low to search on. No clock: times are arguments, monotonic seconds."""

import math
from dataclasses import dataclass
from typing import Final, Literal

from runtime.core.keys import key

RECOVERED_PERCENT: Final = 5.0  # above the bound, from which on it is low no more
LOW_S: Final = 5.0  # so long it must be told to be low
UNSURE_S: Final = 5.0  # many drivers begin with 0, until they have read it


@dataclass(frozen=True)
class BatteryConfig:
    """[battery]: by BatteryState, or as the base tells it."""

    low_percent: float = key(
        15.0,
        "With less in the battery no search is begun; 0: it is not looked at.",
        "%",
        within=(0.0, 100.0),
    )
    when_low: Literal["return", "end", "refuse"] = key(
        "return",
        'What becomes of a search that is under way: "return" drives back to where it began and '
        'ends there, "end" ends it at once, "refuse" lets it go on.',
    )


class Charge:
    """What a battery was told to hold. A 0 that nothing else came before is believed only when it
    has stood for a while; it then is, however often or seldom it was told."""

    def __init__(self) -> None:
        self._percent: float | None = None
        self._told_s, self._since_s = -math.inf, math.inf  # last, and a 0 first
        self._was_read = False  # something but 0 was told

    def tell(self, percent: float | None, now_s: float) -> None:
        """0 to 100, or that it is not known."""
        if percent == 0.0:
            self._since_s = min(self._since_s, now_s)
        self._was_read |= percent is not None and percent > 0.0
        self._percent, self._told_s = percent, now_s

    def percent(self, now_s: float, worth_s: float = math.inf) -> float | None:
        """None where it is not known, or was told longer ago than that is worth."""
        unsure = self._percent == 0.0 and not self._was_read
        if now_s - self._told_s > worth_s or (unsure and now_s - self._since_s < UNSURE_S):
            return None
        return self._percent


class Battery:
    """Told what is in it; says when that is too little, in words for people, "" when it is not, or
    when nobody knows."""

    def __init__(self, config: BatteryConfig) -> None:
        self._config = config
        self._since_s: float | None = None  # when it was told to be low first
        self._low = False

    def refuses(self, percent: float | None) -> str:
        """Why no search is begun now."""
        bound = self._config.low_percent + (RECOVERED_PERCENT if self._low else 0.0)
        return self._words(percent) if self._below(percent, bound) else ""

    def runs_low(self, percent: float | None, now_s: float) -> str:
        """Why a search that is under way does not just go on; called at every frame."""
        if percent is None:
            return ""
        if self._low:
            self._low = self._below(percent, self._config.low_percent + RECOVERED_PERCENT)
        elif not self._below(percent, self._config.low_percent):
            self._since_s = None
        else:
            self._since_s = now_s if self._since_s is None else self._since_s
            self._low = now_s - self._since_s >= LOW_S
        return self._words(percent) if self._low else ""

    def _below(self, percent: float | None, bound: float) -> bool:
        return percent is not None and self._config.low_percent > 0 and percent < bound

    def _words(self, percent: float | None) -> str:
        least = self._config.low_percent
        return f"battery: {percent:.0f} % is left, battery.low_percent is {least:g}"
