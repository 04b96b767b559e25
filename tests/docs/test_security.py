"""What docs/security.md tells a reader to type lets a laptop in, as it stands there."""

import json
import re
import socket
import subprocess
import sys
import threading
from pathlib import Path

import zenoh
from authority import certified
from places import ROOT

from runtime.clock import SystemClock
from runtime.config import load
from runtime.core.types import Pose
from runtime.robot import wire
from runtime.robot.bus import Bus

PAGE = (ROOT / "docs" / "security.md").read_text(encoding="utf-8")
PATIENCE_S = 20.0


def block(language: str) -> str:
    [found] = re.findall(rf"^```{language}\n(.*?)^```$", PAGE, re.MULTILINE | re.DOTALL)
    return str(found)


def free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


def bridge(port: int) -> zenoh.Session:
    """What the robot's own topics come from: a router on loopback."""
    config = zenoh.Config()
    told = {
        "mode": "router", "listen/endpoints": [f"tcp/127.0.0.1:{port}"],
        "scouting/multicast/enabled": False,
    }  # fmt: skip
    for key, value in told.items():
        config.insert_json5(key, json.dumps(value))
    return zenoh.open(config)


def test_the_laptop_is_answered_while_the_robots_topics_come(tmp_path: Path) -> None:
    inside, outside = free_port(), free_port()
    robot = certified(tmp_path, "robot", "127.0.0.1")
    certified(tmp_path, "laptop", "localhost")
    places = {
        "127.0.0.1:7447": f"127.0.0.1:{inside}",
        "0.0.0.0:7448": f"127.0.0.1:{outside}",
        "192.168.1.20:7448": f"127.0.0.1:{outside}",
        "/etc/rf-nav/": f"{tmp_path}/",
        **{f'"{name}': f'"{tmp_path}/{name}' for name in ("ca.pem", "laptop")},
    }
    texts = {"robot.toml": block("toml"), "laptop.json5": block("json5"), "ask.py": block("python")}
    for name, text in texts.items():
        for was, now in places.items():
            if name != "ask.py":
                text = text.replace(was, now)
        (tmp_path / name).write_text(text)
    config = load(tmp_path / "robot.toml")
    assert config.bus.tls == robot
    over = threading.Event()
    odometry = wire.encode_odometry(Pose(1, 2, 0.5), 10**9)
    with bridge(inside) as session, Bus(config.bus, SystemClock()) as bus:

        def serve() -> None:
            while not over.is_set():
                bus.wait_request(0.05)
                while (request := bus.request()) is not None:
                    request.reply({"state": "ready", "odom": bus.pose() is not None})
                session.put("odom", odometry)

        thread = threading.Thread(target=serve)
        thread.start()
        try:
            for _ in range(20):  # the links are not up yet
                command = [sys.executable, "ask.py"]
                done = subprocess.run(
                    command, cwd=tmp_path, capture_output=True, text=True, timeout=PATIENCE_S
                )
                if '"odom": true' in done.stdout.lower():
                    break
            assert json.loads(done.stdout) == {"state": "ready", "odom": True}, done.stderr
        finally:
            over.set()
            thread.join(PATIENCE_S)
