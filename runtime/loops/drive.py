"""One search on the road: what is done with a frame. The map waits for nobody; what the detectors
saw and what was decided is taken in when it comes."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from time import perf_counter

from runtime import navigate
from runtime.clock import Deadline
from runtime.core.local_policy import as_sent, limited
from runtime.core.mapping.attention import view_of
from runtime.core.motion.safety import Halt
from runtime.core.types import Ballot, Observation, SearchState
from runtime.core.voting import consensus, rehearsal
from runtime.core.world import Command, Mode, World
from runtime.loops.camera_watch import CameraWatch
from runtime.loops.decision_worker import DecisionReply, DecisionRequest
from runtime.loops.detector_worker import Surveyed
from runtime.loops.feedback import NO_MORE, Feedback
from runtime.loops.leaving import Leaving
from runtime.loops.led import Led, led_by
from runtime.loops.means import Means
from runtime.loops.plans import Plan
from runtime.loops.search import Search
from runtime.service.outcomes import FailCause, GoalEnd
from runtime.tracing.stages import Stage

IN_VAIN = (SearchState.NOT_FOUND, SearchState.UNREACHABLE)
AT_ONCE = (Mode.TARGET, Mode.FACE)  # what lies ahead is what matters


@dataclass
class Drive:
    """A search, and what is remembered of it between frames."""

    search: Search
    means: Means
    feedback: Feedback
    halts: dict[str, int]  # by kind, as journaled last
    way: Leaving
    report: dict[str, object] = field(default_factory=dict)  # of the newest step
    camera: CameraWatch = field(default_factory=CameraWatch)
    rehearsed_s: float = -math.inf  # when the last rehearsal began
    led_s: float | None = None  # a hand drives, or nobody can: when its newest frame arrived
    led_by: str = ""  # how that is called in the journal: hand, or held
    left: Observation | None = None  # the last that was led: what was asked before is not adopted
    astray: str = ""  # why the newest frame is of nowhere on the map
    paused: str = ""  # by whom
    paused_s: float = 0.0  # since when
    first_s: float | None = None  # when its first frame arrived
    uncharged: bool = False  # it began before anybody knew what is in the battery
    usd: float | None = None  # what it has cost, once the models are another goal's

    def see(self, obs: Observation, frame_s: float) -> GoalEnd | None:
        """One frame, that arrived at `frame_s`; how the search ends by it, or None."""
        if self._is_astray(obs):
            return None  # the plan grows old, and that holds the base
        self.first_s = frame_s if self.first_s is None else self.first_s
        condition = self.means.control.condition()
        led = led_by(condition, self.paused)
        if led is not None:
            self._led(obs, frame_s, led)
            return None
        self._given_back()
        ends = self._run_low(condition.battery_percent, frame_s) or self.over(frame_s)
        if ends is not None:
            return ends
        if self.camera.repeats(obs, frame_s):
            if self.camera.doubt is not None:
                self.plan(None, frame_s, self.report, self.camera.doubt)
            return None
        search, tracer = self.search, self.means.tracer
        began_s = perf_counter()
        world = self._perceive(obs, frame_s)
        now_s = search.timed("map", began_s)
        if self.way.end is None and search.whereabouts.searching:
            with tracer.stage(Stage.DECIDE):
                self._decide(world)
            now_s = search.timed("decide", now_s)
        with tracer.stage(Stage.ACT):
            command = self.way.act(world)
        search.timed("plan", now_s)
        with tracer.stage(Stage.REPORT):
            return self._follow(world, command, frame_s)

    def plan(
        self,
        command: Command | None,
        frame_s: float,
        report: dict[str, object],
        doubt: Halt | None = None,
    ) -> None:
        """Have the control loop follow a command's course; without one, stand. `doubt`: why, of a
        robot that would drive on."""
        cfg, world = self.search.config.navigate, self.search.world
        limits = limited(world, cfg) if world is not None else cfg.control
        course = command.course if command else None
        self.means.control.follow(Plan(course, frame_s, cfg.robot.radius_m, limits, report, doubt))

    def tell(
        self,
        state: SearchState,
        reason: str,
        always: bool = False,
        result: Mapping[str, object] = NO_MORE,
    ) -> None:
        """Feedback on the goal; with its result, when it has ended."""
        self.means.telemetry.does(reason)
        now_s = self.means.clock.now_s()
        told: dict[str, object] = {"usd": self._spent_usd(), "paused": self.paused}
        self.feedback.tell(self.means.bus, state, reason, now_s, always, told | dict(result))

    def over(self, now_s: float) -> GoalEnd | None:
        """How it ends by its limits, whether or not frames come; None while it does not. Its time
        is counted from its first frame on."""
        if self.led_s is not None or self.paused:
            return None
        if self.way.end is not None:
            return self.way.lost()
        since_s = self.feedback.began_s if self.first_s is None else self.first_s
        elapsed_s = now_s - since_s - self.feedback.led_s
        end = self.search.passed(elapsed_s, self.feedback.way_m())
        return self.way.ends(end) if end is not None else None

    def pause(self, by: str) -> None:
        """Stand from now on, or with "" go on; what comes is mapped and looked at all the same."""
        now_s = self.means.clock.now_s()
        if self.paused:  # until now, whether or not frames came
            self.feedback.led_s += now_s - max(self.paused_s, self.led_s or 0.0)
            self.led_s = now_s if self.led_s is not None else None
            if not by and self.led_by == "paused":
                self._given_back()
        self.paused, self.paused_s = by, now_s
        if by:
            reason = f"paused by {by}"
            told = self.report | {"mode": "pause", "reason": reason, "paused": reason}
            self.plan(None, now_s, told)
            self.tell(SearchState.SEARCHING, reason, always=True)

    def elapsed_s(self) -> float:
        """How long the search has taken."""
        return self.feedback.elapsed_s(self.means.clock.now_s())

    def facts(self) -> dict[str, object]:
        """What is told of the search with its result."""
        return self.feedback.facts(self.means.clock.now_s(), self._spent_usd())

    def note_halt(self) -> None:
        """Journal when the base was held since the last look."""
        halts = self.means.control.halts()
        if halts != self.halts:
            reason = self.means.control.halted()
            self.search.journal.write("halt", halts=halts, reason=reason)
            self.halts = halts

    def note_overruns(self) -> None:
        """Journal what took too long, and do less for a while where that is due."""
        means = self.means
        overruns = means.tracer.overruns()
        for overrun in overruns:
            self.search.journal.write("overrun", **vars(overrun))
        if means.shedding.note(overruns, means.clock.now_s()):
            self.search.journal.write("shed", **means.shedding.told())
        means.detector.rest = means.shedding.rest

    # -- inside --------------------------------------------------------------------------------

    def _spent_usd(self) -> float:
        return self.means.spent_usd() if self.usd is None else self.usd

    def _is_astray(self, obs: Observation) -> bool:
        """Whether a frame is of somewhere that the map cannot reach; journaled when that begins."""
        why = self.search.astray(obs)
        if why:
            self.tell(SearchState.SEARCHING, why)
            if not self.astray:
                self.search.journal.write("astray", reason=why)
        self.astray = why
        return bool(why)

    def _perceive(self, obs: Observation, frame_s: float, led: bool = False) -> World:
        """Take in a frame, what the body has met since the one before, and what was seen in earlier
        ones."""
        search, means, tracer = self.search, self.means, self.means.tracer
        with tracer.stage(Stage.PREPARE):
            obs = search.prepared(obs)
        if search.world is not None:
            if not led:
                search.world.body.asked_mps = means.control.asked_mps()
                search.world.body.held = means.control.held()
            navigate.feel_edges(search.world, means.bus.cliffs_watched())
            for met in means.control.met():
                navigate.meet(search.world, met, search.config.navigate)
                search.journal.write("met", **vars(met))
        with tracer.stage(Stage.SURVEY):
            outline = search.survey(obs, led)
        world = search.world
        assert world is not None  # it was surveyed
        tracer.book(Stage.FRAME, means.clock.now_s() - frame_s)
        self._have_looked_at(Surveyed(search, obs, outline, frame_s), world)
        with tracer.stage(Stage.PLACE):
            self._place()
        return world

    def _led(self, obs: Observation, frame_s: float, led: Led) -> None:
        """A frame while a hand drives, or nobody can or may (a base that is not armed, a pause): it
        is mapped and looked at, but no time of the search passes, nothing is decided, and no plan
        is made."""
        if self.led_s is None:
            self.search.journal.write(led.kind, who=led.who, pose=obs.pose)
            self.led_s, self.led_by = frame_s, led.kind
        self.feedback.led_s += frame_s - self.led_s
        self.led_s, self.left = frame_s, obs
        if not self.camera.repeats(obs, frame_s):
            self.means.drawer.note(self._perceive(obs, frame_s, led=True), None)
        told = self.report | {"mode": led.mode, "reason": led.reason}
        told |= {"paused": led.reason} if self.paused else {}
        self.plan(None, frame_s, told)
        self.tell(SearchState.SEARCHING, led.reason)

    def _given_back(self) -> None:
        if self.led_s is not None:
            self.led_s = None
            assert self.left is not None
            self.search.journal.write(self.led_by, who="", pose=self.left.pose)

    def _run_low(self, percent: float | None, frame_s: float) -> GoalEnd | None:
        """The end of a search that the battery is too low for, or None; it may have to go back."""
        means = self.means
        low = means.battery.runs_low(percent, frame_s)
        if percent is not None and not means.battery.refuses(percent):
            self.uncharged = False
        goes_on = means.when_low == "refuse" and not self.uncharged  # else it is refused now
        if not low or self.way.end is not None or goes_on:
            return None
        self.search.journal.write("battery", percent=percent, reason=low, then=means.when_low)
        return self.way.ends(GoalEnd(SearchState.FAILED, low, FailCause.BATTERY))

    def _have_looked_at(self, surveyed: Surveyed, world: World) -> None:
        last = world.body.last
        view = view_of(surveyed.outline, surveyed.obs.pose)
        self.means.detector.offer(surveyed, view, last is not None and last.mode in AT_ONCE)

    def _place(self) -> None:
        """What the detectors saw meanwhile, by the pose and the depth of its own image."""
        means, search = self.means, self.search
        ahead = not means.shedding.experts
        for look in means.detector.take():
            if look.of.asker is not search:
                continue
            search.place(look.of.obs, look.detections, look.of.outline, means.models, ahead)
            means.drawer.seen(look.of.obs.stamp_ns, look.detections, search.order.names)
            search.seconds["detect"] = search.seconds.get("detect", 0.0) + look.took_s
            means.tracer.book(Stage.SEEN, means.clock.now_s() - look.of.frame_s)

    def _decide(self, world: World) -> None:
        """Adopt what was decided meanwhile, and begin to decide when that is due. The robot does
        not wait for the first vote: it makes for the closest frontier until it comes."""
        means, search = self.means, self.search
        cfg, worker = search.config, means.decisions
        answer = worker.take()
        if answer is not None and self._holds(answer):
            brief = answer.question.snapshot.brief
            report = search.decided(answer.decision, brief, world, answer.rehearsal)
            means.bus.publish_decision(
                {"id": search.order.id, "number": search.decisions, **report}
            )
            self._remember(answer, world)
            search.billed(means.models)
        busy = worker.busy
        means.tracer.note("decisions", "vote" if busy else "")
        why = "" if busy else navigate.due(world, cfg.navigate)
        if not why:
            self._rehearse(world)
            return
        seen = navigate.outlook(world, why, cfg.navigate)
        if world.standing.decision is None:
            rule, at_ns = cfg.navigate.consensus, seen.stamp_ns
            first = consensus.elect(Ballot(), seen.candidates, rule, at_ns, why)
            navigate.adopt(world, first)
        by = Deadline.after(cfg.panel.votes_s, means.clock)
        worker.ask(DecisionRequest(search, seen, search.order.panel, by, cfg.navigate))

    def _remember(self, answer: DecisionReply, world: World) -> None:
        """For whoever asks why."""
        search, decision, asked = self.search, answer.decision, answer.question.snapshot
        rank = search.config.navigate.consensus.rank
        heads_for = consensus.successor(decision, world.frontiers, rank)
        told = search.decisions, search.goal.text, decision, asked.brief, asked.frontiers
        self.means.telemetry.decided(*told, heads_for, self.elapsed_s())

    def _holds(self, answer: DecisionReply) -> bool:
        """Whether an answer is to what this search asked, from where the robot came by itself."""
        question = answer.question
        later = self.left is None or question.snapshot.stamp_ns > self.left.stamp_ns
        return question.asker is self.search and later

    def _rehearse(self, world: World) -> None:
        """On the way to a frontier: the next decision, for the map without it. Only where votes
        are slow, and there is time."""
        means, cfg, standing = self.means, self.search.config, world.standing.decision
        if standing is None or means.shedding.experts or not means.decisions.idle:
            return
        now_s = means.clock.now_s()
        rested = now_s - self.rehearsed_s >= rehearsal.EVERY_S
        if not rested or not rehearsal.worthwhile(standing.ballot):
            return
        aim = consensus.successor(standing, world.frontiers, cfg.navigate.consensus.rank)
        if aim is None:
            return
        self.rehearsed_s = now_s
        by = Deadline.after(cfg.panel.votes_s, means.clock)
        seen, panel = navigate.outlook(world, "rehearsal", cfg.navigate), self.search.order.panel
        question = DecisionRequest(self.search, seen, panel, by, cfg.navigate, without=aim)
        means.tracer.note("decisions", "rehearsal")
        means.decisions.rehearse(question)

    def _behind(self) -> bool:
        """Whether something waits to be looked at that may be the goal."""
        behind = self.means.detector.behind()
        self.search.record("heard", {"name": "behind", "value": behind})
        return behind

    def _follow(self, world: World, command: Command, frame_s: float) -> GoalEnd | None:
        """Have the control loop follow the command's course; booked is what it sent last."""
        means, search = self.means, self.search
        if command.ended in IN_VAIN and self._behind():
            command = replace(command, ended=None, reason=f"{command.reason}, but in what waits")
        command = world.body.told(as_sent(command, means.control.sent()))
        report = search.stepped(world, command, means.models.rung())
        told = {"seconds": dict(search.seconds), "models": means.models.health()}
        self.report = report | {"goal": search.goal.text, **means.lacks(), **told}
        means.drawer.note(world, command)
        if command.ended is not None:
            end = self.way.concluded(command, command.ended)
            if end is not None:
                return end
        self.plan(command if command.ended is None else None, frame_s, self.report)
        self.tell(SearchState.SEARCHING, command.reason)
        return None
