"""This search's decisions and stops, so that a page can go back through them."""

import json
import threading
import zlib
from collections import OrderedDict
from collections.abc import Mapping
from typing import Any, Final

DECISIONS_KEPT: Final = 200  # each takes a few KB, packed
STOPS_KEPT: Final = 64


class SearchHistory:
    """Any thread. Numbers are of the service: decisions of one search, stops since its start."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._id = self._goal = ""
        self._decisions: dict[int, tuple[dict[str, Any], bytes]] = {}  # by number, ascending
        self._stops: OrderedDict[int, dict[str, Any]] = OrderedDict()

    def forget(self) -> None:
        """The service was started anew, and counts from the beginning."""
        with self._lock:
            self._id = self._goal = ""
            self._decisions, self._stops = {}, OrderedDict()

    @property
    def last(self) -> int:
        """The number of the newest decision; 0 before the first."""
        with self._lock:
            return next(reversed(self._decisions), 0)

    def decided(self, decision: Mapping[str, Any], scene: str, t_s: float | None) -> bool:
        """A decision of the goal of that `id`; whether that is news, which one is not that is known
        with its votes. `scene`: JSON, what the map was drawn with, "" where nobody looked. Another
        goal's begins anew; one that comes late is put in its place."""
        number, id = int(decision["number"]), str(decision["id"])
        told = {
            "number": number,
            "t_s": t_s,
            "frontier": decision.get("frontier"),
            "in_words": decision.get("in_words") or _first_words(decision),
        }
        kept = zlib.compress(json.dumps([decision, scene]).encode(), 1)
        with self._lock:
            if id != self._id:
                self._id, self._decisions = id, {}
            self._goal = str(decision["goal"])
            if number in self._decisions and "votes" not in decision:
                return False
            every = {**self._decisions, number: (told, kept)}
            self._decisions = dict(sorted(every.items())[-DECISIONS_KEPT:])
            return True

    def stopped(self, stop: Mapping[str, Any], t_s: float | None) -> bool:
        """A stop, as it stands; whether that is new."""
        number = int(stop["number"])
        with self._lock:
            before = self._stops.get(number)
            told = {name: stop.get(name) for name in ("number", "state", "halt", "reason", "over")}
            told["t_s"] = before["t_s"] if before is not None else t_s
            if told == before:
                return False
            for earlier in self._stops.values():
                earlier["over"] = earlier["over"] or earlier["number"] < number
            self._stops[number] = told
            while len(self._stops) > STOPS_KEPT:
                self._stops.popitem(last=False)
            return True

    def decision(self, number: object) -> dict[str, Any]:
        """One of them, with `scene` as it was then, or null. ValueError, one line, for another."""
        with self._lock:
            kept = self._decisions.get(number) if isinstance(number, int) else None
        if kept is None:
            raise ValueError(f"decision {str(number)[:20]}: was not seen by this page's server")
        decision, scene = json.loads(zlib.decompress(kept[1]))
        return {**decision, "t_s": kept[0]["t_s"], "scene": json.loads(scene) if scene else None}

    def timeline(self) -> dict[str, Any]:
        """What a page draws a line of."""
        with self._lock:
            decisions = [told for told, _ in self._decisions.values()]
            stops = [dict(told) for told in self._stops.values()]
            return {"id": self._id, "goal": self._goal, "decisions": decisions, "stops": stops}


def _first_words(decision: Mapping[str, Any]) -> str:
    """Of a decision that is known in words alone."""
    return next((str(line) for line in decision.get("full") or () if "aken" in str(line)), "")
