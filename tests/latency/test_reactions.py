"""How soon the base is told to stand after what must stop it: `rfnav run` and its watchdog as
processes, over Zenoh. Judged above a thread that only sleeps, which tells what the machine itself
takes; the median of a few trials."""

import os
import signal
import statistics
import subprocess
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

import pytest
from apartment import TWO_ROOMS, Apartment
from other_half import flag
from robot_double import RobotDouble
from run_process import process

from runtime.core.motion.safety import SafetyConfig
from runtime.core.types import Pose
from runtime.guard import SILENCE_S
from runtime.robot import wire

TRIALS = 3
WITHIN_S = 0.1  # of what stops the base; where it is an age, after that age
# From the event to the command four threads have to be run by the machine, each as late as one that
# sleeps: the robot's, Zenoh's on both sides, and the control loop's.
HOPS = 4
PATIENCE_S = 60.0
SAFETY = SafetyConfig()
# Far more than what is tried here, so that a busy machine holds the base for nothing else. The
# camera of the robot's double is slow.
DEPTH_S = 1.5
CALM = (
    "control.look_radps=1.0",
    "safety.plan_stale_s=5.0",
    "safety.frame_stale_s=4.0",
    f"safety.depth_stale_s={DEPTH_S}",
)


class Witness:
    """A thread that sleeps, and how late it was woken."""

    def __init__(self) -> None:
        self._ending = threading.Event()
        self._late: list[tuple[float, float]] = []
        self._thread = threading.Thread(target=self._sleep)

    def _sleep(self) -> None:
        while not self._ending.is_set():
            due_s = time.monotonic() + 0.01
            time.sleep(0.01)
            now_s = time.monotonic()
            self._late.append((now_s, now_s - due_s))

    def worst_s(self, since_s: float) -> float:
        return max((late_s for at_s, late_s in self._late if at_s >= since_s), default=0.0)

    def __enter__(self) -> "Witness":
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._ending.set()
        self._thread.join()


class Trial:
    """One runtime and its robot; when zero was commanded."""

    def __init__(self, child: subprocess.Popen[str], robot: RobotDouble) -> None:
        self.child, self.robot = child, robot
        self.heard: list[tuple[float, bool]] = []  # when, and whether it was zero
        self._listener = robot.session.declare_subscriber("cmd_vel", self._obey)

    def _obey(self, sample) -> None:
        told = wire.decode_twist(sample.payload.to_bytes(), "cmd_vel")
        self.heard.append((time.monotonic(), told == (0.0, 0.0)))

    def drive(self) -> None:
        """Have a search under way, and the base in motion for a few commands."""
        by_s = time.monotonic() + PATIENCE_S
        while not (len(self.heard) > 6 and not any(zero for _, zero in self.heard[-6:])):
            assert time.monotonic() < by_s, self.robot.state()
            assert self.child.poll() is None, self.child.communicate()[1]
            if self.robot.state().get("state") != "searching":
                self.robot.ask("goal", {"goal": "toilet"})
                time.sleep(0.5)
            time.sleep(0.01)

    def zero_after(self, since_s: float) -> float:
        """Seconds until zero was commanded."""
        by_s = time.monotonic() + PATIENCE_S
        while True:
            zeros = [at_s for at_s, zero in tuple(self.heard) if zero and at_s > since_s]
            if zeros:
                return zeros[0] - since_s
            assert time.monotonic() < by_s, "zero was never commanded"
            time.sleep(0.005)


@contextmanager
def running(tmp_path: Path) -> Iterator[Trial]:
    home = Apartment.of(TWO_ROOMS, Pose(4.0, 3.0, -0.5))
    env = os.environ | {"XDG_STATE_HOME": str(tmp_path)}
    with process(home, 1_000_000, *CALM, env=env) as (child, robot):
        robot.ask("status")
        yield Trial(child, robot)


def judged(trial: Trial, age_s: float, event: Callable[[Trial], None]) -> float:
    """Seconds from what must stop the base to zero, without the age that it takes to notice, and
    without what the machine took."""
    trial.drive()
    with Witness() as witness:
        time.sleep(0.05)
        began_s = time.monotonic()
        event(trial)
        took_s = trial.zero_after(began_s)
        return took_s - age_s - HOPS * witness.worst_s(began_s)


def silent(trial: Trial) -> None:
    trial.robot.sending.discard("odom")


def dark(trial: Trial) -> None:
    """Depth is lost; colour and odometry live."""
    trial.robot.blind = True


def glitch(trial: Trial) -> None:
    glitches = iter([True])
    trial.robot.bend = lambda pose: (
        replace(pose, x_m=pose.x_m + 5.0) if next(glitches, False) else pose
    )


def cancel(trial: Trial) -> None:
    threading.Thread(target=trial.robot.ask, args=("cancel",)).start()


def button(trial: Trial) -> None:
    trial.robot.session.put("stop", flag(True))


def recover(trial: Trial) -> None:
    """What the robot does again after a trial."""
    trial.robot.sending.add("odom")
    trial.robot.blind = False
    trial.robot.bend = lambda pose: pose
    trial.robot.session.put("stop", flag(False))
    time.sleep(0.3)
    assert trial.robot.ask("release")["released"]


# Odometry comes 20 times a second: the newest may be that old when no more comes, or a glitch is
# due that much later.
ODOMETRY_S = 0.05


@pytest.mark.slow
@pytest.mark.parametrize(
    ("event", "age_s"),
    [
        (silent, SAFETY.odom_stale_s),
        (dark, DEPTH_S),
        (glitch, ODOMETRY_S),
        (cancel, 0.0),
        (button, 0.0),
    ],
)
def test_zero_soon_after_what_must_stop_the_base(
    tmp_path: Path, event: Callable[[Trial], None], age_s: float
):
    took = []
    with running(tmp_path) as trial:
        for _ in range(TRIALS):
            took.append(judged(trial, age_s, event))
            recover(trial)
    print(event.__name__, [round(s, 3) for s in took])
    assert statistics.median(took) <= WITHIN_S, took


def end(trial: Trial) -> None:
    trial.child.send_signal(signal.SIGTERM)


def stand_still(trial: Trial) -> None:
    trial.child.send_signal(signal.SIGSTOP)


def kill(trial: Trial) -> None:
    trial.child.kill()


@pytest.mark.slow
@pytest.mark.parametrize(("event", "age_s"), [(end, 0.0), (stand_still, SILENCE_S), (kill, 0.0)])
def test_zero_soon_after_the_process_cannot_go_on(
    tmp_path: Path, event: Callable[[Trial], None], age_s: float
):
    took = []
    for n in range(TRIALS):
        with running(tmp_path / str(n)) as trial:
            took.append(judged(trial, age_s, event))
    print(event.__name__, [round(s, 3) for s in took])
    assert statistics.median(took) <= WITHIN_S, took


@pytest.mark.slow
def test_a_process_that_was_stopped_and_goes_on_does_not_drive_by_what_it_knew(tmp_path: Path):
    with running(tmp_path) as trial:
        trial.drive()
        trial.child.send_signal(signal.SIGSTOP)
        trial.zero_after(time.monotonic())
        time.sleep(1.0)
        trial.child.send_signal(signal.SIGCONT)
        trial.robot.until(lambda: trial.robot.state().get("halts", {}).get("overrun"))
        trial.drive()  # and goes on, by a plan of what it sees now
