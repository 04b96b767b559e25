"""One run of the bench: a runtime of its own process with all models, a drive that is played to it
in real time through Zenoh, and beside it a process that only sleeps."""

import json
import math
import os
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from concurrent.futures import TimeoutError as NotYet
from contextlib import AbstractContextManager, contextmanager, nullcontext
from dataclasses import dataclass
from itertools import chain, cycle
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import zenoh

from runtime.bench.synthetic import Published
from runtime.errors import BusError, RfNavError
from runtime.robot import wire
from runtime.robot.json_text import parse_json
from runtime.robot.session import CANCEL, GOAL, STATUS, BusConfig, TopicsConfig, open_session
from runtime.tracing.stages import Stage

READY_S = 120.0  # after which a runtime that does not answer is given up
ASK_S = 30.0
LEAD_S = 3.0  # that sensors are heard before the goal
ENDS_S = 20.0
GO_ON = ("goal.keep_map=true",)  # there is no first look around then: it is decided at once
WORDS = "research.word_evidence=language"  # the dearest there is
GOAL_S = 14.0  # after which the next is asked for, where there are several,
POLL_S = 0.5  # or as soon as the experts were idle for half of such a time
MB = 1024.0  # kB
SAID = "said.txt"


class BenchError(RfNavError):
    """A runtime that did not come up, or ended."""


@dataclass(frozen=True)
class Subject:
    """What is measured: the code in `root` (None: this one), with `arguments` of `rfnav run`."""

    arguments: Sequence[str] = ()
    root: Path | None = None


@dataclass(frozen=True)
class Measured:
    """Figures of one run. `stages` and `sleeper` as Histogram.told has them."""

    stages: dict[str, dict[str, float]]
    sleeper: dict[str, float]
    seconds: float
    ready_s: float
    first_command_s: float | None
    memory_mb: float
    grown_mb: float  # over the second half
    halts: dict[str, int]
    decisions: int
    goals: int = 1  # that were asked for in turn, if there was time


def measured(
    subject: Subject,
    goals: Sequence[str],
    drive: Iterable[Published],
    topics: TopicsConfig,
    hz: float,
    beside: Callable[[str], AbstractContextManager[object]] = nullcontext,
) -> Measured:
    """Play a drive to a runtime that is asked for one of the goals after the other, each for
    GOAL_S, or until its experts have no more to do; for a single one until the end. `beside`: what
    else goes on meanwhile on the bus of that endpoint. BenchError when the runtime ends."""
    with TemporaryDirectory() as folder, _sleeper(hz) as sleeper:
        endpoint = f"tcp/127.0.0.1:{free_port()}"
        session: Any = open_session(BusConfig(listen=(endpoint,)))
        began_s = time.monotonic()
        child = _spawned(subject, endpoint, Path(folder))
        try:
            robot = _Robot(session, topics, child, Path(folder) / SAID)
            ready_s = robot.ready() - began_s
            with beside(endpoint), robot.playing(drive) as played:
                time.sleep(LEAD_S)
                _write(sleeper, "clear\n")
                asked_s = time.monotonic()
                half_mb = robot.search(goals, played)
            played_s, memory_mb = time.monotonic() - asked_s, resident_mb(child)
            status = robot.ask(STATUS, {})
            robot.ask(CANCEL, {"reason": "the drive is over"})
        finally:
            child.terminate()
            _ended(child)
            session.close()
        told, _ = sleeper.communicate(timeout=ENDS_S)
    return Measured(
        status.get("stages", {}),
        json.loads(told),
        played_s,
        ready_s,
        robot.moved_s - asked_s if robot.moved_s else None,
        memory_mb,
        memory_mb - half_mb,
        status.get("halts", {}),
        int(status.get("decisions", 0)),
        len(goals),
    )


class _Robot:
    """The other end of the wire."""

    def __init__(
        self, session: Any, topics: TopicsConfig, child: subprocess.Popen[str], said: Path
    ) -> None:
        self._session, self._child, self._said = session, child, said
        self.moved_s: float | None = None  # when the first command came that moves the base
        self._hears = session.declare_subscriber(topics.cmd_vel, self._hear)
        self._publishers: dict[str, Any] = {}

    def ready(self) -> float:
        """Wait until the runtime takes goals; returns when that was."""
        by_s = time.monotonic() + READY_S
        while time.monotonic() < by_s:
            if self._try(STATUS, {}) is not None:
                return time.monotonic()
            time.sleep(0.02)
        raise BenchError(f"the runtime did not answer within {READY_S:g} s")

    def ask(self, query: str, body: dict[str, object]) -> dict[str, Any]:
        answer = self._try(query, body)
        if answer is None or answer.get("accepted") is False:
            raise BenchError(f"{query}: {(answer or {}).get('error', 'no answer')}")
        return answer

    def search(self, goals: Sequence[str], played: Future[float]) -> float:
        """Ask for the goals in turn until a drive was played; what that came to."""
        if len(goals) == 1:
            self.ask(GOAL, {"goal": goals[0]})
            return played.result()
        for goal in cycle(goals):
            self.ask(GOAL, {"goal": goal, "settings": [*GO_ON]})
            by_s, scored_s = time.monotonic() + GOAL_S, -math.inf
            while time.monotonic() < by_s:
                try:
                    return played.result(POLL_S)
                except NotYet:
                    if played.done():  # of its own, then
                        raise
                before_s, scored_s = scored_s, self._scored_s()
                if scored_s - before_s < POLL_S / 2:
                    break
        raise BenchError("there is nothing to look for")

    def _scored_s(self) -> float:
        """For how long the language model was at work."""
        stages: dict[str, dict[str, float]] = self.ask(STATUS, {}).get("stages", {})
        return stages.get(Stage.SCORE, {}).get("total_s", 0.0)

    @contextmanager
    def playing(self, drive: Iterable[Published]) -> Iterator[Future[float]]:
        """A drive under way: its first message is there. In the end comes the runtime's memory at
        half of it, MB. What goes wrong meanwhile ends it."""
        messages = iter(drive)
        first = next(messages, None)  # a drive may take a while to begin
        if first is None:
            raise BenchError("there is nothing to play")
        stopping = threading.Event()
        with ThreadPoolExecutor(1) as pool:
            try:
                yield pool.submit(self._play, chain((first,), messages), first.at_ns, stopping)
            finally:
                stopping.set()

    def _play(self, drive: Iterable[Published], first_ns: int, stopping: threading.Event) -> float:
        """Publish each message at its time."""
        began_s, sizes = time.monotonic(), [(0.0, resident_mb(self._child))]
        for message in drive:
            at_s = (message.at_ns - first_ns) / 1e9
            if stopping.wait(max(0.0, began_s + at_s - time.monotonic())):
                break
            self._publish(message)
            if at_s >= sizes[-1][0] + 1.0:
                sizes.append((at_s, resident_mb(self._child)))
        return sizes[len(sizes) // 2][1]

    def _publish(self, message: Published) -> None:
        if message.topic not in self._publishers:
            block = zenoh.CongestionControl.BLOCK
            publisher = self._session.declare_publisher(message.topic, congestion_control=block)
            self._publishers[message.topic] = publisher
        try:
            self._publishers[message.topic].put(message.payload)
        except zenoh.ZError as error:
            raise BusError(f"{message.topic}: cannot be published: {error}") from error

    def _try(self, query: str, body: dict[str, object]) -> dict[str, Any] | None:
        if self._child.poll() is not None:
            text = self._said.read_text(encoding="utf-8", errors="replace")
            said = text.strip().splitlines()[-1:] or ["nothing"]
            raise BenchError(f"the runtime ended and said: {said[0]}")
        for reply in self._session.get(query, payload=json.dumps(body), timeout=ASK_S):
            if reply.ok is not None:
                return parse_json(reply.ok.payload.to_bytes(), query)
        return None

    def _hear(self, sample: zenoh.Sample) -> None:
        if self.moved_s is None and any(wire.decode_twist(sample.payload.to_bytes(), "cmd_vel")):
            self.moved_s = time.monotonic()


def _spawned(subject: Subject, endpoint: str, folder: Path) -> subprocess.Popen[str]:
    """What it says goes to a file, as nobody reads a pipe while it runs and a full one stops it;
    what its searches leave goes there, too."""
    bus = ("--set", f"bus.connect=['{endpoint}']", "--set", "bus.mode=peer")
    # Code of before may know no other evidence, and no such key.
    words = ("--set", WORDS) if subject.root is None else ()
    command = [sys.executable, "-m", "runtime", "run", *words, *subject.arguments, *bus]
    more = {"XDG_STATE_HOME": str(folder)}
    more |= {"PYTHONPATH": str(subject.root)} if subject.root else {}
    with (folder / SAID).open("w", encoding="utf-8") as file:
        return subprocess.Popen(
            command, env={**os.environ, **more}, cwd=subject.root, stderr=file, text=True
        )


def _ended(child: subprocess.Popen[str]) -> None:
    try:
        child.wait(ENDS_S)
    except subprocess.TimeoutExpired:
        child.kill()
        child.wait()


@contextmanager
def _sleeper(hz: float) -> Iterator[subprocess.Popen[str]]:
    command = [sys.executable, "-m", "runtime.bench.sleeper", str(hz)]
    pipe = subprocess.PIPE
    process = subprocess.Popen(command, text=True, stdin=pipe, stdout=pipe)
    try:
        yield process
    finally:
        if process.poll() is None:
            process.kill()
            process.communicate()


def _write(process: subprocess.Popen[str], line: str) -> None:
    assert process.stdin is not None
    process.stdin.write(line)
    process.stdin.flush()


def resident_mb(child: subprocess.Popen[str]) -> float:
    """What a process holds in memory; 0 for one that has ended."""
    try:
        status = Path(f"/proc/{child.pid}/status").read_text(encoding="ascii")
    except OSError:
        return 0.0
    lines = (line.split() for line in status.splitlines())
    return next((int(words[1]) / MB for words in lines if words[:1] == ["VmRSS:"]), 0.0)


def free_port() -> int:
    """Where nobody listens on this computer."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])
