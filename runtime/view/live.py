"""A feed from the service that runs: heard and asked while somebody looks, and else left alone."""

import resource
import threading
import time
from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager, ExitStack, closing
from dataclasses import dataclass
from typing import Any, Final

import zenoh

from runtime.clock import SystemClock
from runtime.config import Config
from runtime.errors import BusError, RfNavError
from runtime.robot import wire
from runtime.robot.dialects.choice import spoken
from runtime.robot.heard_topics import heard_topics
from runtime.robot.ros_node import Publisher, RosNode, Sending
from runtime.service.telemetry import memory_bytes
from runtime.tracing.budgets import Budgets
from runtime.view import told
from runtime.view.asking import asked
from runtime.view.feed import Audience, Content
from runtime.view.hearing import FAULTS, PageHearing
from runtime.view.history import SearchHistory
from runtime.view.questions import AskedService, PageQuestions
from runtime.view.sticks import PageSticks
from runtime.view.tiles import TileMap

TURN_S: Final = 0.1  # between two looks at what was heard
TELL_S: Final = 1.0  # between two states where nothing changes
RETRY_S: Final = 1.0
LINGER_S: Final = 5.0  # after the last page has gone: one that is loaded anew is served at once
SILENT_S: Final = 2.0
LOST_S: Final = 4.0  # without a word of the service: the session is opened anew
ANSWER_S: Final = 5.0
STOP_S: Final = 1.0

Connect = Callable[[], AbstractContextManager[AskedService]]


@dataclass(frozen=True)
class LiveParts:
    """`connect`: a session to the service, BusError where nobody listens; `wrong`: what of a status
    is not as it should be."""

    connect: Connect
    config: Config
    budgets: Budgets
    wrong: Callable[[Content], Sequence[str]]


class LiveFeed:
    """A `Feed`. A thread keeps the link and asks, another reads what is heard."""

    def __init__(self, parts: LiveParts) -> None:
        self._parts, self._bus = parts, parts.config.bus
        self.tiles, self._history = TileMap(), SearchHistory()
        control = parts.config.navigate.control
        self._most = control.max_speed_mps, control.max_turn_radps
        self._sticks = PageSticks(self._drive, self._most, self._barred, SystemClock())
        self._changed = threading.Condition()
        self._pages = self._cameras = 0
        self._left_s = -LINGER_S  # when the last page went
        self._closed = False
        self._service: AskedService | None = None
        self._teleop: Publisher | None = None
        self._why = "not asked yet"
        self._own = 0.0, 0.0  # process time and time, s, as of the last health
        self._threads = [
            threading.Thread(target=work, name=f"view {work.__name__}", daemon=True)
            for work in (self._link, self._read)
        ]

    def start(self, audience: Audience) -> None:
        self._audience = audience
        self._hearing = PageHearing(self._bus, audience, self.tiles, self._decided)
        parts = self._parts
        beside = audience, self._hearing, self._history, self.tiles
        self._questions = PageQuestions(*beside, parts.budgets, parts.wrong, self._fares)
        for thread in self._threads:
            thread.start()

    def welcome(self) -> dict[str, Any]:
        most = {"max_v_mps": self._most[0], "max_w_radps": self._most[1]}
        can = {"teleop": bool(self._bus.topics.teleop), "command": True, "camera": True}
        robot = {"radius_m": self._parts.config.navigate.robot.radius_m}
        stages = told.budgets_of(self._parts.budgets)
        return {"mode": "live", "robot": robot, "budgets": stages, **most, "can": can, "file": None}

    def attend(self, pages: int, cameras: int) -> None:
        with self._changed:
            if self._pages and not pages:
                self._left_s = time.monotonic()
            self._pages, self._cameras = pages, cameras
            self._changed.notify_all()

    def ask(self, what: str, body: object) -> dict[str, Any]:
        if what == "decision":
            return self._history.decision(body.get("number") if isinstance(body, dict) else None)
        query = asked(what, body)
        if what == "goal" and self._loads():  # or it would begin when nobody looks any more
            raise BusError("its models still load: ask for it when the robot is ready")
        if what == "stop":
            self._sticks.drop()
        try:
            answer = self._answer(what, query, STOP_S if what == "stop" else ANSWER_S)
        except zenoh.ZError as error:
            raise BusError(f"{what}: the link was lost: {error}") from error
        self._questions.soon(what)
        self._questions.soon("stops" if what in ("stop", "release") else "status")
        with self._changed:
            self._changed.notify_all()
        return answer

    def _loads(self) -> bool:
        return told.table(self._hearing.newest.state, "runtime").get("state") == "starting"

    def _answer(self, what: str, query: Content, within_s: float) -> dict[str, Any]:
        service = self._service
        if service is not None:
            try:
                return service.ask(what, query, within_s)
            except BusError:
                if what != "stop":  # which is asked again, over a link of its own
                    raise
        with self._parts.connect() as opened:  # nobody looks, or it was away
            return opened.ask(what, query, within_s)

    def steer(self, who: int, order: Content) -> None:
        if order.get("kind") != "teleop" or self._teleop is None:
            return
        if order.get("end"):
            self._sticks.let_go(who)
            return
        self._sticks.hold(who, told.number(order.get("v")), told.number(order.get("w")))

    def gone(self, who: int) -> None:
        self._sticks.let_go(who)

    def close(self) -> None:
        self._sticks.close()
        with self._changed:
            self._closed = True
            self._changed.notify_all()
        for thread in self._threads:
            if thread.is_alive():
                thread.join(timeout=ANSWER_S)

    # -- the link ----------------------------------------------------------------------------------

    def _link(self) -> None:
        while self._looked_at():
            try:
                with self._parts.connect() as service:
                    self._serve(service)
            except (RfNavError, zenoh.ZError) as error:
                self._why = str(error)
            finally:
                self._service = self._teleop = None
                self._hearing.forget()
                self._questions.forget()
            self._wait(RETRY_S)

    def _serve(self, service: AskedService) -> None:
        """Until nobody looks; BusError when it has fallen silent."""
        began_s = time.monotonic()
        with ExitStack() as stack:
            stack.enter_context(self._hearing.listen(service.session))
            self._offer_sticks(service, stack)
            camera = stack.enter_context(ExitStack())
            self._service, watched = service, False
            while self._attended():
                if watched != (self._cameras > 0):
                    watched = not watched
                    camera.close()
                    if watched:
                        camera.enter_context(self._hearing.watch(service.session))
                self._questions.turn(service)
                known_s = max(self._hearing.newest.state_s, self._questions.answers.status_s)
                if time.monotonic() - max(began_s, known_s) > LOST_S:
                    raise BusError("nobody answers: is rfnav run up?")
                self._wait(TURN_S * 2)

    def _offer_sticks(self, service: AskedService, stack: ExitStack) -> None:
        topic = heard_topics(self._bus).get("teleop")
        if topic is None:
            return
        node = RosNode(service.session, spoken(self._bus, "rfnav_view_sticks"))
        stack.enter_context(closing(node))
        kind = wire.TWIST if self._bus.cmd_vel_type == "Twist" else wire.TWIST_STAMPED
        wanted = type(topic)(topic.name, kind, topic.qos)
        self._teleop = node.publisher(wanted, Sending(urgent=True))

    def _attended(self) -> bool:
        with self._changed:
            recently = time.monotonic() - self._left_s < LINGER_S
            return not self._closed and (self._pages > 0 or recently)

    def _looked_at(self) -> bool:
        """Wait until somebody looks; False when it is over."""
        with self._changed:
            self._changed.wait_for(lambda: self._pages > 0 or self._closed)
            return not self._closed

    def _wait(self, seconds: float) -> None:
        with self._changed:
            if not self._closed:
                self._changed.wait(seconds)

    # -- what is told ------------------------------------------------------------------------------

    def _read(self) -> None:
        told_s = -TELL_S
        while self._looked_at():
            changed = self._hearing.turn()
            now_s = time.monotonic()
            if changed or now_s - told_s >= TELL_S:
                told_s = now_s
                try:
                    self._audience.tell("state", self._state(now_s))
                except FAULTS:
                    self._hearing.bad += 1
            time.sleep(TURN_S)

    def _state(self, now_s: float) -> dict[str, Any]:
        newest, answers = self._hearing.newest, self._questions.answers
        age_s = now_s - newest.state_s
        link, why, known = "ok", "", newest.state_s > 0
        if self._service is None or max(newest.state_s, answers.status_s) < now_s - LOST_S:
            link, why = "no service", self._why
        elif age_s > SILENT_S:
            since = f"for {age_s:.0f} s" if known else "yet"
            link, why = "silent", f"rfnav/state has not come {since}"
        content = told.state_of(newest.state, newest.feedback, answers.status)
        beside = {"age_s": round(age_s, 2) if known else None, "teleop": self._sticks.who}
        return {"link": link, "why": why, **beside, **content}

    def _decided(self, report: Content) -> None:
        self._questions.decided(report)
        with self._changed:
            self._changed.notify_all()

    def _fares(self) -> Content:
        """How this process does."""
        used = resource.getrusage(resource.RUSAGE_SELF)
        now = used.ru_utime + used.ru_stime, time.monotonic()
        share = (now[0] - self._own[0]) / max(now[1] - self._own[1], 1e-3)
        self._own = now
        memory_mb = round(memory_bytes() / 1e6, 1)
        return {"clients": self._pages, "cpu_share": round(share, 3), "memory_mb": memory_mb}

    # -- driving by hand ---------------------------------------------------------------------------

    def _barred(self) -> str:
        """Also while nobody knows whether the robot is stopped."""
        newest = self._hearing.newest
        if time.monotonic() - newest.state_s > SILENT_S:
            return "silent"
        state = told.table(newest.state, "runtime").get("state")
        return "stopped" if state == "stopped" else ""

    def _drive(self, v_mps: float, w_radps: float) -> None:
        teleop = self._teleop
        if teleop is None:
            return
        if self._bus.cmd_vel_type == "Twist":
            payload = wire.encode_twist(v_mps, w_radps)
        else:
            frame = self._bus.cmd_vel_frame
            payload = wire.encode_twist_stamped(v_mps, w_radps, time.time_ns(), frame)
        try:
            teleop.put(payload)
        except BusError:
            self._teleop = None  # the link has gone, and with it the hand
