"""The lockstep loop in a thread, and the harness's end of its bus."""

import json
import threading
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

import zenoh
from apartment import INTRINSICS, TWO_ROOMS, Apartment
from fake_models import FakeModels

from hil_sim.driving.link import free_port
from runtime.clock import SystemClock
from runtime.config import Config, load
from runtime.core.types import Intrinsics, Pose
from runtime.loops.goal_request import Terms
from runtime.loops.lockstep import Lockstep
from runtime.record import Record, unrecorded
from runtime.robot import wire
from runtime.robot.bus import Bus
from runtime.robot.session import ACTION, BusConfig, open_session
from runtime.robot.told_votes import ToldVotes
from runtime.service.zones import zones_beside


class Peer:
    """The harness's end: queries, one observation at a time, the actions that come back."""

    def __init__(self, session: zenoh.Session, topics: BusConfig) -> None:
        self.session, self.topics = session, topics.topics
        self.actions: dict[int, str] = {}
        self.answers: list[dict] = []
        self.heard = threading.Condition()
        self._declared = session.declare_subscriber(ACTION, self._hear)

    def _hear(self, sample: zenoh.Sample) -> None:
        body = wire.decode_json(sample.payload.to_bytes(), "action")
        with self.heard:
            self.actions[body["stamp_ns"]] = body["action"]
            self.answers.append(body)
            self.heard.notify_all()

    def ask(self, query: str, body: dict, tries: int = 40) -> dict:
        for _ in range(tries):
            for reply in self.session.get(f"rfnav/{query}", payload=json.dumps(body), timeout=10.0):
                if reply.ok is not None:
                    return json.loads(reply.ok.payload.to_bytes())
            threading.Event().wait(0.05)  # the link is not up yet
        raise AssertionError(f"nobody answers rfnav/{query}")

    def show(
        self,
        home: Apartment,
        intrinsics: Intrinsics | None = INTRINSICS,
        ended: Sequence[BaseException] = (),
    ) -> str | None:
        """Publish what the home looks like until it is answered, or the loop has ended: messages
        right after a link forms can be lost."""
        obs = home.observe()
        messages = [
            (self.topics.odom, wire.encode_odometry(obs.pose, obs.stamp_ns)),
            (self.topics.depth, wire.encode_depth(obs.depth_m, obs.stamp_ns)),
            (self.topics.color, wire.encode_color(obs.rgb, obs.stamp_ns)),
        ]
        if intrinsics is not None:
            info = wire.encode_camera_info(intrinsics, obs.stamp_ns)
            messages.insert(0, (self.topics.camera_info, info))
        for _ in range(30):
            for topic, payload in messages:
                self.session.put(topic, payload)
            with self.heard:
                self.heard.wait_for(lambda: obs.stamp_ns in self.actions or ended, timeout=2.0)
            if obs.stamp_ns in self.actions or ended:
                break
        return self.actions.get(obs.stamp_ns)


@contextmanager
def running(
    models: FakeModels, *settings: str, record: Record = unrecorded
) -> Iterator[tuple[Peer, list[BaseException]]]:
    """The loop in a thread, and a peer linked to it."""
    endpoint = f"tcp/127.0.0.1:{free_port()}"
    harness = BusConfig(listen=(endpoint,))
    session = open_session(harness)
    ending, ended = threading.Event(), []

    def configure(more: Sequence[str]) -> Config:
        return load(None, [f"bus.connect=['{endpoint}']", *settings, *more])

    clock = SystemClock()

    def serve() -> None:
        try:
            with Bus(configure(()).bus, clock, lockstep=True, record=record) as bus:
                zones = zones_beside(bus, kept=False)
                answers = {"zones": lambda request: zones.answer(request.body)}
                terms = Terms(True, zones=zones)
                told = ToldVotes(bus.node, clock)
                loop = Lockstep(bus, models, configure, clock, record, terms, answers, told)
                loop.run(ending.is_set)
        except BaseException as error:  # noqa: BLE001 -- handed to the test
            ended.append(error)

    thread = threading.Thread(target=serve)
    thread.start()
    peer = Peer(session, harness)
    try:
        yield peer, ended
    finally:
        ending.set()
        thread.join(timeout=20.0)
        models.panel.close()
        peer._declared.undeclare()
        session.close()
        assert not thread.is_alive()


def home() -> Apartment:
    return Apartment.of(TWO_ROOMS, Pose(4.0, 3.0, 0.0))


def begin(peer: Peer, log: Path, goal: str = "toilet") -> dict:
    return peer.ask("goal", {"goal": goal, "episode": "e1", "log_dir": str(log)})
