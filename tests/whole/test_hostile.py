"""What an attack tried (its numbers 5, 6, 7 and 9) against `rfnav run` as a robot starts it: every
request is answered, nothing ends the process, and the robot still searches afterwards."""

import json
import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest
from apartment import INTRINSICS, TWO_ROOMS, Apartment
from onnx import TensorProto, helper
from places import ROOT
from robot_double import RobotDouble

from hil_sim.driving.link import free_port
from runtime.core.types import Intrinsics, Pose
from runtime.robot import wire
from runtime.robot.session import BusConfig

pytestmark = pytest.mark.slow  # whole processes

READY_S = 120.0
ANSWER_S = 60.0
FASTEST_MPS, FASTEST_RADPS = 0.4, 1.0  # as the configuration has it


@dataclass
class Victim:
    """The process, its robot, and its state directory."""

    process: subprocess.Popen[bytes]
    robot: RobotDouble
    state: Path
    log: Path

    def ask(self, query: str, payload: bytes) -> dict[str, Any]:
        """The answer; there has to be one."""
        replies = self.robot.session.get(f"rfnav/{query}", payload=payload, timeout=ANSWER_S)
        found = [json.loads(reply.ok.payload.to_bytes()) for reply in replies if reply.ok]
        assert found, f"{query}: no answer to {payload[:80]!r}"
        return found[0]

    def alive(self) -> None:
        assert self.process.poll() is None, self.log.read_text()

    def moves(self) -> None:
        """A goal is accepted, and the robot drives."""
        answer = self.ask("goal", b'{"goal":"refrigerator"}')
        assert answer["accepted"], answer
        self.robot.until(lambda: self.robot.twist.v_mps > 0.1 or self.process.poll() is not None)
        self.alive()


def start(
    state: Path, port: int, *settings: str, log: Path, home: Path | None = None
) -> subprocess.Popen[bytes]:
    """`home`: where all else is that a process may write to without being told; the cache, where
    models are, stays where it is."""
    command = [sys.executable, "-m", "runtime", "run", "--set"]
    command += [f"bus.connect=['tcp/127.0.0.1:{port}']"]
    for setting in settings:
        command += ["--set", setting]
    env = {**os.environ, "XDG_STATE_HOME": str(state), "PYTHONPATH": str(ROOT)}
    if home is not None:
        env.setdefault("XDG_CACHE_HOME", str(Path.home() / ".cache"))
        env |= {"HOME": str(home), "TMPDIR": str(home / "tmp")}
        (home / "tmp").mkdir(parents=True)
    with log.open("wb") as file:
        return subprocess.Popen(command, stdout=file, stderr=file, cwd=home or ROOT, env=env)


@pytest.fixture(scope="module")
def victim(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Victim]:
    folder, port = tmp_path_factory.mktemp("victim"), free_port()
    home = Apartment.of(TWO_ROOMS, Pose(4.0, 3.0, 0.0))
    robot = RobotDouble(home, BusConfig(listen=(f"tcp/127.0.0.1:{port}",)))
    log, state = folder / "runtime.log", folder / "state"
    quick = "panel.experts=[]", "safety.odom_stale_s=2.0", "safety.frame_stale_s=4.0"
    quick += "safety.plan_stale_s=5.0", "safety.depth_stale_s=2.0"
    process = start(state, port, *quick, log=log, home=folder / "home")
    robot.start()
    try:
        robot.ask("status", tries=round(READY_S / 0.1))
        yield Victim(process, robot, state, log)
    finally:
        robot.close()
        process.terminate()
        process.wait(30.0)


def goal(**body: object) -> bytes:
    return json.dumps({"goal": "bed", **body}).encode()


def nested(depth: int) -> bytes:
    return b'{"goal":"bed","episode":' + b"[" * depth + b"]" * depth + b"}"


def setting(text: str) -> bytes:
    return goal(settings=[text])


REFUSED = {
    "brace": b"{", "utf16": '{"goal":"bed"}'.encode("utf-16"), "array": b"[]", "null": b"null",
    "empty": b"", "number": goal(goal=5), "long": goal(goal="a" * 300_000),
    "zero": goal(goal="bed\0"), "surrogate": b'{"goal":"\\ud800"}', "unknown": goal(speed=9),
    "nan": b'{"goal":"bed","episode":NaN}',
    "bigint": b'{"goal":"bed","episode":' + b"9" * 5000 + b"}",
    "nest-100k": nested(100_000), "nest-900": nested(900), "nest-400": nested(400),
    "log-dir-nul": goal(log_dir="x\0y"), "log-dir-long": goal(log_dir="a" * 5000),
    "log-dir-proc": goal(log_dir="/proc/1/x"), "log-dir-relative": goal(log_dir="../w"),
    "set-nest": setting("map.max_depth_m=" + "[" * 5000),
    "set-bigint": setting("map.max_depth_m=" + "9" * 5000),
    "set-speed": goal(settings=["control.max_speed_mps=50", "control.max_turn_radps=30"]),
    "set-res": setting("map.resolution_m=1e-6"), "set-side": setting("map.side_m=1e6"),
    "set-stride": setting("map.stride=0"), "set-z": setting("camera.z_m=nan"),
    "set-radius": setting("robot.radius_m=inf"), "set-depth": setting("map.max_depth_m=inf"),
    "set-threads": setting("models.threads=1"),
    "set-labels": setting('research.detector_labels=[""]'),
    "set-budget": setting("panel.decide_budget_s=inf"),
    "set-experts": setting('panel.experts=["r2d2"]'), "set-keep": setting("goal.keep_map=7"),
}  # fmt: skip


def test_every_bad_goal_is_refused_in_a_line_and_nothing_else_happens(victim: Victim):
    for name, payload in REFUSED.items():
        answer = victim.ask("goal", payload)
        assert answer["accepted"] is False, name
        assert "internal" not in answer["error"], (name, answer)
        assert "\n" not in answer["error"], name
        assert len(answer["error"]) < 400, name
    victim.alive()
    assert victim.ask("status", b"\xff\0")["state"] == "ready"
    assert not victim.state.exists() or not any(victim.state.rglob("decisions.jsonl"))


def test_a_directory_that_a_goal_names_is_left_as_it_is(victim: Victim, tmp_path: Path):
    precious = tmp_path / "decisions.jsonl"
    precious.write_text("precious\n")
    answer = victim.ask("goal", goal(log_dir=str(tmp_path)))
    assert "only under rfnav run --harness" in answer["error"]
    assert precious.read_text() == "precious\n"
    assert list(tmp_path.iterdir()) == [precious]


def test_files_are_left_in_the_state_directory_alone(victim: Victim):
    """Beside what is kept of words in the cache."""
    folder = victim.state.parent
    there, elsewhere = folder / "elsewhere", folder / "home" / "elsewhere"
    for path in (there, elsewhere, Path("elsewhere"), Path("../elsewhere")):
        assert not victim.ask("goal", goal(log_dir=str(path)))["accepted"]
        for key in ("research.score_file", "models.vocabulary", "cloud.key_file"):
            refused = victim.ask("goal", goal(settings=[f"{key}='{path}'"]))
            assert "is the robot's, not a goal's to set" in refused["error"]
    victim.moves()
    victim.ask("cancel", b"{}")
    files = {path.relative_to(folder) for path in folder.rglob("*") if path.is_file()}
    kept = {file for file in files if file.parts[:2] == ("state", "rf-nav")}
    assert {file.name for file in kept} >= {"decisions.jsonl", "map.npz"}
    assert files - kept == {Path("runtime.log")}


def test_no_goal_raises_the_robots_limits(victim: Victim):
    victim.moves()
    victim.ask("goal", REFUSED["set-speed"])
    time.sleep(2.0)
    speeds = [(abs(t.v_mps), abs(t.w_radps)) for t in victim.robot.commands]
    assert max(v for v, _ in speeds) <= FASTEST_MPS + 1e-6
    assert max(w for _, w in speeds) <= FASTEST_RADPS + 1e-6
    victim.ask("cancel", b"{}")


@pytest.mark.parametrize(
    "payload",
    [b'{"reason":"' + b"x" * 300_000 + b'"}', b'{"reason":"\\ud800\\n"}', b'{"reason":{"a":[1]}}',
     b"", b"\xff\0", b"[" * 900],
)  # fmt: skip
def test_a_cancel_cancels_whatever_it_says(victim: Victim, payload: bytes):
    victim.moves()
    assert victim.ask("cancel", payload)["state"] == "cancelled"
    robot = victim.robot
    robot.until(lambda: robot.twist.v_mps == robot.twist.w_radps == 0)
    victim.alive()


def test_a_cancel_comes_through_a_flood_of_goals_each_of_which_is_answered(victim: Victim):
    answered = []

    def ask() -> None:
        for n in range(100):
            answered.append(victim.ask("goal", goal(goal=("bed", "sofa")[n % 2])))

    victim.moves()
    askers = [threading.Thread(target=ask) for _ in range(8)]
    for asker in askers:
        asker.start()
    time.sleep(3.0)
    began_s = time.monotonic()
    victim.ask("cancel", b"{}")
    took_s = time.monotonic() - began_s
    for asker in askers:
        asker.join()
    victim.ask("cancel", b"{}")
    assert len(answered) == 800
    assert any("busy" in answer.get("error", "") for answer in answered)
    assert took_s < ANSWER_S / 4  # it waits for the one goal that is being understood
    folders = [path.parent for path in victim.state.rglob("decisions.jsonl")]
    accepted = sum(bool(answer["accepted"]) for answer in answered)
    assert len(folders) >= accepted  # each with a journal of its own
    victim.alive()


INFO, FX = "camera/color/camera_info", INTRINSICS.fx
SIZE = INTRINSICS.width, INTRINSICS.height


def info(fx: float, fy: float, cx: float, cy: float, size: tuple[int, int] = SIZE) -> bytes:
    return wire.encode_camera_info(Intrinsics(fx, fy, cx, cy, *size), 0)


SENSORS = {
    "odom-1e9": ("odom", wire.encode_odometry(Pose(1e9, 0.0, 0.0), 0)),
    "odom-1e300": ("odom", wire.encode_odometry(Pose(1e300, 1e300, 0.0), 0)),
    "odom-1km": ("odom", wire.encode_odometry(Pose(1000.0, 1000.0, 0.0), 0)),
    "odom-nan": ("odom", wire.encode_odometry(Pose(float("nan"), 0.0, 0.0), 0)),
    "odom-cut": ("odom", wire.encode_odometry(Pose(0.0, 0.0, 0.0), 0)[:40]),
    "info-cx-1e300": (INFO, info(FX, FX, 1e300, 60.0)),
    "info-fx-1e-300": (INFO, info(1e-300, 1e-300, 80.0, 60.0)),
    "info-zeroK": (INFO, info(0.0, 0.0, 0.0, 0.0)),
    "info-size": (INFO, info(9.0, 9.0, 8.0, 8.0, (16, 16))),
    "color-junk": ("camera/color/image_raw", b"\0\1\0\0" + b"\xff" * 200),
    "depth-huge": ("camera/depth/image_raw", bytes(65_000_000)),
}  # fmt: skip


@pytest.mark.parametrize("name", SENSORS)
def test_what_no_sensor_sends_ends_nothing(victim: Victim, name: str):
    topic, payload = SENSORS[name]
    victim.moves()
    for _ in range(4 if len(payload) > 1e6 else 100):
        stamp = time.time_ns().to_bytes(8, "little")
        sec, nanosec = divmod(int.from_bytes(stamp, "little"), 10**9)
        stamped = payload[:4] + sec.to_bytes(4, "little") + nanosec.to_bytes(4, "little")
        victim.robot.session.put(topic, stamped + payload[12:])
        time.sleep(0.005)
    victim.moves()
    victim.ask("cancel", b"{}")
    journal = max(victim.state.rglob("map.npz"), key=lambda path: path.stat().st_mtime)
    assert journal.stat().st_size < 5e6
    assert int(Path(f"/proc/{victim.process.pid}/statm").read_text().split()[1]) * 4096 < 3e9


def test_sigterm_is_heard_while_models_load(tmp_path: Path):
    port, heard = free_port(), []
    home = Apartment.of(TWO_ROOMS, Pose(4.0, 3.0, 0.0))
    robot = RobotDouble(home, BusConfig(listen=(f"tcp/127.0.0.1:{port}",)))
    process = start(tmp_path, port, log=tmp_path / "log")
    robot.start()
    try:
        robot.until(lambda: robot.commands or process.poll() is not None)  # zeros, from the start
        began_s = time.monotonic()
        process.send_signal(signal.SIGTERM)
        assert process.wait(20.0) == 0
        heard.append(time.monotonic() - began_s)
        assert all(twist.v_mps == twist.w_radps == 0 for twist in robot.commands)
    finally:
        process.kill()
        robot.close()
    assert heard[0] < 10.0  # a minute and more is what loading takes on a busy machine


def test_a_network_that_never_ends_is_refused_at_the_start(tmp_path: Path):
    """Its graph is a loop of 2^62 rounds."""
    path = tmp_path / "loop.onnx"
    path.write_bytes(endless())
    done = subprocess.run(
        [sys.executable, "-m", "runtime", "run", "--set", f'models.detectors=["{path}"]',
         "--set", f"bus.connect=['tcp/127.0.0.1:{free_port()}']"],
        capture_output=True, text=True, timeout=400, check=False, cwd=ROOT,
    )  # fmt: skip
    assert done.returncode == 2, done.stderr
    assert "loop.onnx" in done.stderr.splitlines()[-1]


def endless() -> bytes:
    body = helper.make_graph(
        [helper.make_node("Identity", ["going"], ["on"]),
         helper.make_node("Add", ["x", "x"], ["y"])],
        "body",
        [helper.make_tensor_value_info("n", TensorProto.INT64, []),
         helper.make_tensor_value_info("going", TensorProto.BOOL, []),
         helper.make_tensor_value_info("x", TensorProto.FLOAT, [1, 3, 320, 320])],
        [helper.make_tensor_value_info("on", TensorProto.BOOL, []),
         helper.make_tensor_value_info("y", TensorProto.FLOAT, [1, 3, 320, 320])],
    )  # fmt: skip
    graph = helper.make_graph(
        [helper.make_node("Loop", ["most", "yes", "image"], ["out"], body=body)],
        "endless",
        [helper.make_tensor_value_info("image", TensorProto.FLOAT, [1, 3, 320, 320])],
        [helper.make_tensor_value_info("out", TensorProto.FLOAT, [1, 3, 320, 320])],
        [helper.make_tensor("most", TensorProto.INT64, [], [2**62]),
         helper.make_tensor("yes", TensorProto.BOOL, [], [True])],
    )  # fmt: skip
    made = helper.make_model(graph, opset_imports=[helper.make_opsetid("", 17)], ir_version=8)
    return bytes(made.SerializeToString())
