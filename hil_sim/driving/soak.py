"""A soak: goals one after the other for a robot that lives beside a service, while one thing after
another goes wrong with either. What is counted is what a person beside the robot would mind."""

import threading
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Final

from hil_sim.driving.installed_service import Service, beside
from hil_sim.driving.living_robot import LivingRobot
from hil_sim.driving.soak_plan import PROCESS, STANDS, TURNS, Trouble
from hil_sim.simulation.robot import Robot

STOPS_WITHIN_S: Final = 1.6
"""After the begin of a trouble in which it must stand: 0.5 s until depth counts as missing, or a
base hears nothing any more, 0.6 s to brake from full speed, and half a second for a machine that
does much else."""
REPEATS_S: Final = {"camera-freeze": 0.4}
"""More, where the first frame of a trouble is a true one, and only the next tells."""
STARTS_AGAIN_S: Final = 3.0  # no service is back sooner
CREEPS_MPS, CREEPS_RADPS = 0.03, 0.05
MEMORY_S: Final = 5.0  # between two looks at the service's memory
MOST_MB: Final = 900.0  # resident, of a life that leaks nothing


@dataclass
class Suffered:
    """What became of the robot in one trouble."""

    trouble: Trouble
    moved: bool = False  # when it began
    longest_s: float = 0.0  # that it went on moving, or moved again
    since_s: float | None = None  # when it began to move
    collisions: int = 0

    @property
    def must_stand(self) -> bool:
        return self.trouble.name in STANDS

    @property
    def missed(self) -> bool:
        """A stop that was due and did not come."""
        due_s = STOPS_WITHIN_S + REPEATS_S.get(self.trouble.name, 0.0)
        return self.must_stand and self.longest_s > due_s

    def note(self, now_s: float, moves: bool) -> None:
        """How it is now. What only shows in motion, a camera that freezes, may be tried again."""
        if not moves:
            self.since_s = None
            return
        self.since_s = now_s if self.since_s is None else self.since_s
        self.longest_s = max(self.longest_s, now_s - self.since_s)


@dataclass
class Watch:
    """Follows a robot through its troubles, tick by tick."""

    troubles: tuple[Trouble, ...]
    felt: list[Suffered] = field(default_factory=list)
    collisions: int = 0
    _last: Robot | None = None

    def note(self, now_s: float, robot: Robot) -> None:
        """How the robot is, so many seconds after its begin."""
        new = robot.collisions - (self._last.collisions if self._last else 0)
        self._last = robot
        self.collisions += new
        moves = abs(robot.twist.v_mps) > CREEPS_MPS or abs(robot.twist.w_radps) > CREEPS_RADPS
        while len(self.felt) < len(self.troubles) and now_s >= self._next().at_s:
            self.felt.append(Suffered(self._next(), moves))
        if not self.felt:
            return
        felt = self.felt[-1]
        if now_s - felt.trouble.at_s <= self._lasts_s(felt.trouble):
            felt.collisions += new
            drives = abs(robot.twist.v_mps) > CREEPS_MPS
            felt.note(now_s, drives if felt.trouble.name in TURNS else moves)

    def missed(self) -> tuple[Suffered, ...]:
        return tuple(felt for felt in self.felt if felt.missed)

    def _next(self) -> Trouble:
        return self.troubles[len(self.felt)]

    def _lasts_s(self, trouble: Trouble) -> float:
        if trouble.name in ("kill", "restart"):
            return STARTS_AGAIN_S
        return trouble.lasts_s


@dataclass
class Memory:
    """The service's, MB: most of each of its lives."""

    most: dict[int, float] = field(default_factory=dict)
    next_s: float = 0.0

    def note(self, life: int, now_mb: float | None) -> None:
        if now_mb is not None:
            self.most[life] = max(now_mb, self.most.get(life, 0.0))


def soak(
    robot: LivingRobot,
    service: Service,
    troubles: tuple[Trouble, ...],
    seconds: float,
    say: Callable[[str], None] = lambda line: None,
) -> tuple[Watch, Memory]:
    """Let the robot live for so long; whoever gives it goals does so beside this."""
    watch, memory = Watch(troubles), Memory()
    doing: list[threading.Thread] = []
    failed: list[BaseException] = []
    waiting = list(troubles)
    while robot.now_s < seconds and not failed:
        robot.tick()
        watch.note(robot.now_s, robot.robot)
        if waiting and robot.now_s >= waiting[0].at_s:
            trouble = waiting.pop(0)
            say(f"{robot.now_s:6.1f} s  {trouble.name} for {trouble.lasts_s:g} s")
            if trouble.name in PROCESS:
                doing.append(_beside(service, trouble, failed))
        if robot.now_s >= memory.next_s:
            memory.next_s = robot.now_s + MEMORY_S
            doing.append(_measured(service, memory, failed))
        doing = [thread for thread in doing if thread.is_alive()]
    for thread in doing:
        thread.join()
    if failed:
        raise failed[0]
    return watch, memory


def _beside(service: Service, trouble: Trouble, failed: list[BaseException]) -> threading.Thread:
    return _thread(lambda: beside(service, trouble.name, trouble.lasts_s), failed)


def _measured(service: Service, memory: Memory, failed: list[BaseException]) -> threading.Thread:
    return _thread(lambda: memory.note(service.starts(), service.memory_mb()), failed)


def _thread(work: Callable[[], None], failed: list[BaseException]) -> threading.Thread:
    def run() -> None:
        try:
            work()
        except BaseException as error:  # noqa: BLE001 -- raised again by `soak`
            failed.append(error)

    thread = threading.Thread(target=run, daemon=True)
    thread.start()
    return thread


def wrong(watch: Watch, memory: Memory, lost: int, broken: int) -> list[str]:
    """What is not as it has to be; a collision may be the hand's that drove. `lost`: goals that
    never had a result; `broken`: saved files that could not be read after a restart."""
    grown = sum(mb > MOST_MB for mb in memory.most.values())
    counts = {
        "stops that were due and did not come": len(watch.missed()),
        "goals without a result": lost,
        "saved files that could not be read": broken,
        f"lives of more than {MOST_MB:g} MB": grown,
    }
    return [f"{what}: {count}" for what, count in counts.items() if count]


def told(watch: Watch, memory: Memory, goals: Counter[str], lost: int, broken: int) -> list[str]:
    """The report, for people; see `wrong`."""
    rows = [f"{'trouble':16} times  moving  moved on, most     collisions"]
    for name in sorted({felt.trouble.name for felt in watch.felt}):
        of = [felt for felt in watch.felt if felt.trouble.name == name]
        stood = [felt.longest_s for felt in of if felt.must_stand]
        most = f"{max(stood):.2f} s" if stood else "-"
        moving, hit = sum(felt.moved for felt in of), sum(felt.collisions for felt in of)
        rows.append(f"{name:16} {len(of):5}  {moving:6}  {most:>17}  {hit:10}")
    ended = ", ".join(f"{name} {number}" for name, number in sorted(goals.items()))
    lives = [f"{mb:.0f}" for _, mb in sorted(memory.most.items())]
    faults = wrong(watch, memory, lost, broken)
    return [
        *rows,
        f"stops that were due and did not come: {len(watch.missed())}",
        f"collisions: {watch.collisions}",
        f"goals: {sum(goals.values())} with a result ({ended}), {lost} without",
        f"saved files that could not be read: {broken}",
        f"memory, most of each life: {', '.join(lives)} MB",
        f"outlived: {'no: ' + '; '.join(faults) if faults else 'yes'}",
    ]
