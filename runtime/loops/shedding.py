"""What is done less of for a while where stages overrun: first looks of the detectors, then what
experts prepare. Control never."""

from collections import deque

from runtime.tracing.budgets import Budgets, Shed
from runtime.tracing.tracer import Overrun

ENOUGH = 3  # overruns within WITHIN_S; one alone is nobody's fault
WITHIN_S = 2.0
SETTLE_S = 2.0  # a step is given so long to help
CALM_S = 10.0  # without ENOUGH overruns, after which a step is taken back
RESTS = (0.0, 1.0, 3.0)  # of the detector, in lengths of its looks: all, half, a quarter of them


class Shedding:
    """Steps up at overruns, down in calm. Times are monotonic seconds."""

    def __init__(self, budgets: Budgets) -> None:
        self._shed = {stage: budget.shed for stage, budget in budgets.stages.items()}
        self._detector, self._experts = 0, False
        self._recent: dict[Shed, deque[float]] = {kind: deque(maxlen=ENOUGH) for kind in Shed}
        self._changed_s = -SETTLE_S
        self.steps = 0  # so often something was shed

    @property
    def rest(self) -> float:
        """How long the detector rests after a look, in lengths of that look."""
        return RESTS[self._detector]

    @property
    def experts(self) -> bool:
        """Whether what experts would prepare is left out."""
        return self._experts

    def note(self, overruns: list[Overrun], now_s: float) -> bool:
        """What came since this was called last; whether what is shed changed."""
        for overrun in overruns:
            self._recent[self._shed.get(overrun.stage, Shed.NOTHING)].append(now_s)
        if now_s - self._changed_s < SETTLE_S:
            return False
        for kind in (Shed.DETECTOR, Shed.EXPERTS):
            recent = self._recent[kind]
            if len(recent) == ENOUGH and now_s - recent[0] <= WITHIN_S:
                recent.clear()
                return self._more(kind, now_s)
        return now_s - self._changed_s >= CALM_S and self._less(now_s)

    def in_words(self) -> str:
        """For people; "" when nothing is shed."""
        parts = []
        if self._detector:
            parts.append(f"one look of the detectors in {1 + self.rest:g}")
        if self._experts:
            parts.append("nothing prepared for the experts")
        return f"shed to be in time: {', '.join(parts)}" if parts else ""

    def told(self) -> dict[str, object]:
        """As JSON."""
        return {"detector_rest": self.rest, "experts": self._experts, "steps": self.steps}

    def _more(self, kind: Shed, now_s: float) -> bool:
        if kind is Shed.DETECTOR and self._detector + 1 < len(RESTS):
            self._detector += 1
        elif not self._experts:
            self._experts = True
        else:
            self._changed_s = now_s  # all is shed that may be: no calm either
            return False
        self._changed_s = now_s
        self.steps += 1
        return True

    def _less(self, now_s: float) -> bool:
        if not (self._experts or self._detector):
            return False
        if self._experts:
            self._experts = False
        else:
            self._detector -= 1
        self._changed_s = now_s
        return True
