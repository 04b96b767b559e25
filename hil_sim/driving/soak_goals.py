"""Whoever gives goals to a service in a soak, as people do: one after the other, now and then
cancelled or paused; and wants a result for each."""

import json
import threading
import time
from collections import Counter
from collections.abc import Sequence
from typing import Any, Final

import numpy as np
import zenoh

from runtime.errors import SensorError
from runtime.robot.json_text import parse_json
from runtime.robot.session import BusConfig, open_session

REPLY_S: Final = 30.0  # on a machine that does much else; that nobody is there is told at once
LONGEST_S: Final = 40.0  # of a search, by its own limit
PATIENCE_S: Final = 120.0  # until a result, through restarts
CANCELS, PAUSES = 0.2, 0.2  # of goals


class Asking(threading.Thread):
    """A thread that asks until `leave`. `results`: how many goals ended how; `lost`: ids of those
    whose result never came; `refused`: why goals were not taken while the service was up."""

    def __init__(self, endpoint: str, goals: Sequence[str], seed: int) -> None:
        super().__init__(daemon=True)
        self._session: Any = open_session(BusConfig(mode="client", connect=(endpoint,)))
        self._goals, self._rng = tuple(goals), np.random.default_rng(seed)
        self._ending = threading.Event()
        self.results, self.refused = Counter[str](), Counter[str]()
        self.lost: list[str] = []

    def run(self) -> None:
        while not self._ending.is_set():
            goal = str(self._rng.choice(self._goals))
            taken = self._ask("goal", {"goal": goal, "limits": {"time_s": LONGEST_S}})
            if taken is None:
                self._ending.wait(0.5)  # it is not up
            elif not taken.get("accepted"):
                self.refused[str(taken.get("error"))] += 1
                self._ending.wait(2.0)
            else:
                self._follow(str(taken["id"]))
        self._session.close()

    def leave(self) -> None:
        """Cancel what is under way; the thread ends once that has its result."""
        self._ending.set()

    def _follow(self, id: str) -> None:
        """Until it has a result, perhaps with a person's change of mind."""
        until_s = time.monotonic() + PATIENCE_S
        what, after_s = self._mind()
        acts_s = time.monotonic() + after_s
        while time.monotonic() < until_s:
            said = self._ask("result", {"id": id, "wait_s": 1.0})
            if said is not None and said.get("result"):
                self.results[str(said["result"])] += 1
                return
            if self._ending.is_set() or (what and time.monotonic() >= acts_s):
                self._act("cancel" if self._ending.is_set() else what)
                what = ""
            time.sleep(0.3)
        self.lost.append(id)

    def _mind(self) -> tuple[str, float]:
        drawn, after_s = float(self._rng.random()), float(self._rng.uniform(3.0, 15.0))
        if drawn < CANCELS:
            return "cancel", after_s
        return ("pause" if drawn < CANCELS + PAUSES else ""), after_s

    def _act(self, what: str) -> None:
        self._ask(what, {})
        if what == "pause":
            self._ending.wait(3.0)
            self._ask("resume", {})

    def _ask(self, query: str, body: dict[str, object]) -> dict[str, Any] | None:
        """The answer; None when there is nobody to give one."""
        key = f"rfnav/{query}"
        try:
            for reply in self._session.get(key, payload=json.dumps(body), timeout=REPLY_S):
                if reply.ok is not None:
                    return parse_json(reply.ok.payload.to_bytes(), key)
        except (zenoh.ZError, SensorError):
            return None
        return None
