"""The life of goals without threads: nothing of the loop is real but that and the drive, and a
robot in the flat-land apartment that does not move unless a test moves it."""

import json
from collections.abc import Mapping
from contextlib import nullcontext
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

from apartment import TWO_ROOMS, Apartment
from fake_models import FakeModels
from manual_clock import ManualClock

from runtime.config import load
from runtime.core.types import Pose, SearchState, Twist
from runtime.loops.drawings import NoDrawings
from runtime.loops.goal_request import Terms
from runtime.loops.goals import Custom, GoalLife
from runtime.loops.means import Means
from runtime.loops.plans import Plan
from runtime.loops.process import Garbage
from runtime.loops.shedding import Shedding
from runtime.loops.whereabouts import NoZones, ZoneKeeper
from runtime.record import unrecorded
from runtime.robot.base import WELL, BaseCondition
from runtime.robot.battery import Battery
from runtime.robot.requests import Request
from runtime.service.goal_queue import GoalFile
from runtime.service.telemetry import Telemetry
from runtime.tracing.budgets import read_budgets
from runtime.tracing.tracer import Tracer

NO_ZONES = NoZones()


class Asked:
    """A query, and what it was answered."""

    def __init__(self) -> None:
        self.answers: list[dict[str, Any]] = []

    def reply(self, key: str, answer: str) -> None:
        self.answers.append(json.loads(answer))

    def drop(self) -> None:
        """Nothing is held."""


class Bench:
    """`lives`: the goals of one process; `again` is the next process, of the same folder."""

    def __init__(
        self,
        folder: Path,
        *settings: str,
        after_restart: str = "",
        zones: ZoneKeeper = NO_ZONES,
    ) -> None:
        self.zones = zones
        self.folder, self.settings, self.after_restart = folder, settings, after_restart
        self.home = Apartment.of(TWO_ROOMS, Pose(4.0, 3.0, 0.0))
        self.models, self.clock = FakeModels(self.home), ManualClock(100.0)
        self.base, self.withheld = WELL, False
        self.plans: list[Plan] = []
        self.rests: list[SearchState] = []
        self.feedback: list[dict[str, Any]] = []
        self.said: list[str] = []
        self.life = self._life()

    def again(self) -> None:
        """The next process."""
        self.close()
        self.life = self._life()
        self.life.restore()

    def close(self) -> None:
        """What a process that ends gives back by itself."""
        if self.life.drive is not None:
            self.life.drive.search.journal.close()

    def _life(self) -> GoalLife:
        always = 'research.control_mode="velocity"', "panel.experts=[]", *self.settings

        def configure(more):
            return load(None, (*always, *more))

        budgets = read_budgets()
        battery = configure(()).battery
        tracer = Tracer(budgets, self.clock.now_s)
        telemetry = Telemetry(self.clock, tell=lambda line, *_, **fields: self.said.append(line))
        detector = SimpleNamespace(
            paused=nullcontext, begin=lambda newest_only: None, offer=lambda *_: None,
            take=list, behind=lambda: False, rest=0.0,
        )  # fmt: skip
        decisions = SimpleNamespace(
            take=lambda: None, busy=False, idle=False, ask=lambda question: None
        )
        means = Means(
            self, self, self.models, self.clock, decisions, detector, tracer, Shedding(budgets),
            Battery(battery), battery.when_low, NoDrawings(), telemetry,
        )  # fmt: skip
        file = GoalFile(self.folder) if self.after_restart else None
        harness = Terms(True, lambda: self.folder / "search", self.zones)
        custom = Custom(harness, file, self.after_restart or "fail")
        return GoalLife(means, configure, Garbage(self.clock), unrecorded, custom)

    # -- what a test does ----------------------------------------------------------------------

    def ask(self, goal: object = "toilet", **more: object) -> dict[str, Any]:
        return self.life.accept({"goal": goal, **more})

    def request(self, kind: str, **body: object) -> tuple[dict[str, Any] | None, Asked]:
        """The answer of now to a request, and the query, for one that comes later."""
        asked = Asked()
        request = Request(kind, dict(body), asked, f"rfnav/{kind}")
        answer = getattr(self.life, kind)(request)
        return (dict(answer) if answer is not None else None), asked

    def frames(self, count: int = 1, seconds: float = 0.1) -> None:
        """So many more are seen; the robot stands where it is."""
        for _ in range(count):
            self.clock.advance(seconds)
            if self.life.drive is None:
                return
            end = self.life.drive.see(self.home.observe(), self.clock.now_s())
            if end is not None:
                self.life.end(end)

    def stand(self, x: float, y: float) -> None:
        self.home.pose = replace(self.home.pose, x_m=x, y_m=y)

    @property
    def mode(self) -> object:
        return self.plans[-1].report.get("mode")

    def result(self, id: str) -> dict[str, Any]:
        answer, _ = self.request("result", id=id)
        assert answer is not None, "it has not ended"
        return answer

    # -- the control loop, and the bus ---------------------------------------------------------

    def condition(self, forget: bool = True) -> BaseCondition:
        return self.base

    def follow(self, plan: Plan) -> None:
        self.plans.append(plan)

    def rest(self, state: SearchState, report: Mapping[str, object]) -> None:
        self.rests.append(state)

    def halts(self) -> dict[str, int]:
        return {}

    def halted(self) -> str:
        return ""

    def asked_mps(self) -> float:
        return 0.0

    def held(self) -> bool:
        return self.withheld

    def sent(self) -> Twist:
        return Twist()

    def met(self) -> tuple[()]:
        return ()

    def cliffs_watched(self) -> bool:
        return False

    def unstamped(self) -> tuple[()]:
        return ()

    def sweeps(self, *_: object) -> None:
        """Nothing sweeps."""

    def publish_decision(self, decision: Mapping[str, object]) -> None:
        """Nobody listens."""

    def publish_feedback(self, feedback: Mapping[str, object]) -> None:
        self.feedback.append(dict(feedback))
