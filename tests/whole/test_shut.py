"""The runtime as a process: what it leaves is its owner's alone, what it listens to is this
computer's, and a key is nowhere but in its file and on its way to the server that it is for."""

import os
import sys
from pathlib import Path
from typing import Any

import pytest
from apartment import INTRINSICS, TWO_ROOMS, Apartment
from cloud_double import Server

from hil_sim.driving.link import Runtime
from runtime.core.types import Pose
from runtime.journal import read_journal
from runtime.recording.reader import messages

pytestmark = pytest.mark.slow  # whole processes

KEY = "sk-test-0123456789abcdefghijklmnop"
PIECE = 8  # characters of a key that must not be found together
LABELS = {"boxes": [], "names": [], "scores": [], "room": "bathroom"}
STEPS = 16  # twelve looks around, a decision, and some on the way


def quoting(body: dict[str, Any]) -> tuple[int, Any]:
    """A server that tells the whole world what it was sent."""
    return 418, {"error": {"message": f"no account has the key {KEY}"}}


def pieces(content: bytes) -> list[str]:
    found = (KEY[n : n + PIECE] for n in range(len(KEY) - PIECE + 1))
    return [piece for piece in found if piece.encode() in content]


def settings(tmp_path: Path, url: str) -> list[str]:
    key = tmp_path / "key"
    key.write_text(KEY)
    key.chmod(0o600)
    state = tmp_path / "state"
    values = {
        "research.detector_source": "topic",
        "research.score_file": state / "scores.sqlite",
        "research.cloud_spending_file": state / "spending.sqlite",
        "cloud.enabled": "true",
        "cloud.base_url": url,
        "cloud.model": "m",
        "cloud.key_file": key,
        "cloud.price_in_usd": "1.0",
        "cloud.price_out_usd": "1.0",
        "cloud.cap_goal_usd": "1.0",
        "cloud.cap_day_usd": "1.0",
    }
    return [f"{name}={value}" for name, value in values.items()]


def sockets(pid: int) -> set[str]:
    """Where a process listens, or is bound, as addresses in /proc/net (hexadecimal)."""
    own = set()
    for descriptor in Path(f"/proc/{pid}/fd").iterdir():
        try:
            own.add(os.readlink(descriptor))
        except FileNotFoundError:
            continue
    found = set()
    for kind in ("tcp", "tcp6", "udp", "udp6"):
        for line in Path(f"/proc/net/{kind}").read_text().splitlines()[1:]:
            words = line.split()
            if f"socket:[{words[9]}]" in own:
                found.add(words[1].partition(":")[0])
    return found


def test_nothing_of_it_is_open_to_others(tmp_path: Path) -> None:
    home = Apartment.of(TWO_ROOMS, Pose(4.0, 3.0, 0.0))
    log, journal, drives = (tmp_path / name for name in ("log", "a/journal", "drives"))
    # A language model that talks nonsense: the cloud is asked.
    program = [sys.executable, "-m", "hil_sim.driving.faulty_runtime", "nonsense"]
    command = [*program, "run", "--harness", "--lockstep", "--record", str(drives)]
    before = os.umask(0)
    try:
        with Server(quoting) as server:
            runtime = Runtime(log, None, settings(tmp_path, server.url), command)
            os.umask(before)
            with runtime:
                assert runtime.ask("goal", {"goal": "toilet", "log_dir": str(journal)})["accepted"]
                for _ in range(STEPS):
                    obs = home.observe()
                    view = obs.stamp_ns, obs.rgb, obs.depth_m, obs.pose, INTRINSICS
                    home.apply(runtime.exchange(*view, labels=LABELS).action)
                told = [runtime.ask("status", {}), *(dict(value) for _, value in runtime.hear())]
                pid = runtime._child.pid  # type: ignore[union-attr]
                process = {
                    name: Path(f"/proc/{pid}/{name}").read_bytes()
                    for name in ("cmdline", "environ")
                }
                limits = Path(f"/proc/{pid}/limits").read_text()
                local = sockets(pid)
                told.append(runtime.ask("cancel", {}))
            assert server.auth
            assert set(server.auth) == {f"Bearer {KEY}"}  # it was used
    finally:
        os.umask(before)
    assert local <= {"0100007F"}  # 127.0.0.1
    [core] = [line.split() for line in limits.splitlines() if "core file" in line]
    assert core[4:6] == ["0", "0"]
    calls = [line["call"] for line in read_journal(journal / "decisions.jsonl")
             if line["kind"] == "cloud"]  # fmt: skip
    assert calls
    assert all(call["outcome"].startswith("refused (418)") for call in calls)

    written = [p for name in ("a", "state", "drives") for p in (tmp_path / name).rglob("*")]
    assert {p.name for p in written} >= {"decisions.jsonl", "map.npz", "spending.sqlite"}
    assert len(list(drives.glob("*.mcap"))) == 1
    for path in [*(tmp_path / name for name in ("a", "state", "drives")), *written]:
        assert path.stat().st_mode & 0o777 == (0o700 if path.is_dir() else 0o600), path
    said = {"told": repr(told).encode(), "log": log.read_bytes(), **process}
    for path in written:
        if path.is_file():
            said[str(path)] = path.read_bytes()
    [recording] = drives.glob("*.mcap")
    said["recording, unpacked"] = unpacked(recording)
    assert {where: pieces(content) for where, content in said.items() if pieces(content)} == {}


def unpacked(recording: Path) -> bytes:
    """Its chunks are compressed."""
    return b"\n".join(message.payload for message in messages(recording))
