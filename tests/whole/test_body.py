"""Whole searches in PyBullet, in real time, of robots that have more than a camera; and one that a
hand takes over."""

import json
import subprocess
import sys
from pathlib import Path

import pytest
from places import TESTS

from runtime.journal import read_journal
from runtime.recording.reader import messages

pytestmark = pytest.mark.slow  # whole processes

START_XY, GOAL_XY, BETWEEN_XY = (0.8, 1.5), (4.6, 1.5), (2.4, 1.5)


def room(folder: Path, thing: dict | None = None, hole: list | None = None) -> Path:
    """A room with a plant at its far end, and something between that and where the robot begins."""
    corners = [[0, 0], [5.5, 0], [5.5, 3], [0, 3]]
    walls = [
        {"from": a, "to": b, "kind": "outer"}
        for a, b in zip(corners, corners[1:] + corners[:1], strict=True)
    ]
    plant = {"id": "plant", "category": "plant", "mesh": "builtin:plant"}
    objects = [{**plant, "position_m": [*GOAL_XY, 0]}]
    if thing is not None:
        objects.append({"mesh": "builtin:box", "position_m": [*BETWEEN_XY, 0], **thing})
    x, y = START_XY
    near = [[x - 0.1, y - 0.1], [x + 0.1, y - 0.1], [x + 0.1, y + 0.1], [x - 0.1, y + 0.1]]
    scene = {
        "format": "rf-nav-scene/1",
        "name": "room",
        "wall_height_m": 2.5,
        "walls": walls,
        "doors": [],
        "rooms": [{"name": "hall", "type": "hallway", "polygon": corners}],
        "objects": objects,
        "spawn": [near],
        "holes": [{"polygon": hole, "depth_m": 0.5}] if hole else [],
    }
    path = folder / "room.json"
    path.write_text(json.dumps(scene))
    return path


def demo(out: Path, scene: Path, *more: str, goal: str = "plant") -> dict:
    """A search in real time that knows what it sees; its summary."""
    how = ("--realtime", "--method", "oracle-perception", "--protocol", "onrobot")
    done = subprocess.run(
        [sys.executable, "-m", "hil_sim", "demo", "--goal", goal, "--scene", str(scene), *how,
         "--out", str(out), *more],
        capture_output=True, text=True, timeout=600.0, check=False,
    )  # fmt: skip
    assert done.returncode in (0, 1), done.stdout[-2000:] + done.stderr
    return json.loads((out / "summary.json").read_text())


def told(out: Path, kind: str) -> list[dict]:
    return [line for line in read_journal(out / "decisions.jsonl") if line["kind"] == kind]


def replayed(path: Path) -> str:
    (recording,) = path.iterdir()
    return subprocess.run(
        [sys.executable, "-m", "runtime", "replay", str(recording)],
        capture_output=True, text=True, timeout=300.0, check=False,
    ).stdout  # fmt: skip


def test_a_hand_takes_over_in_mid_search_gives_back_and_the_goal_is_found(tmp_path: Path):
    out, kept = tmp_path / "run", tmp_path / "kept"
    hand = "hand:at=8s,for=6s"
    flat = TESTS / "refs/flat.json"
    summary = demo(out, flat, "--fault", hand, "--record", str(kept), goal="toilet")
    assert summary["success"], summary
    taken, given = told(out, "hand")
    assert (taken["who"], given["who"]) == ("cmd_vel_teleop", "")
    assert abs(taken["pose"]["yaw_rad"] - given["pose"]["yaw_rad"]) > 0.5  # it is elsewhere
    sticks, ours = [], []
    for message in messages(next(kept.iterdir())):
        if message.topic == "/cmd_vel_teleop":
            sticks.append(message.log_time_ns)
        elif message.topic == "/cmd_vel":
            ours.append(message.log_time_ns)
    silent = [at for at in ours if sticks[0] + 100_000_000 < at < sticks[-1] + 400_000_000]
    assert len(sticks) > 30
    assert silent == []
    assert any(at > sticks[-1] for at in ours)
    assert replayed(kept).startswith("equal in ")


def test_what_lies_below_what_a_camera_sees_is_met_by_the_bumper_and_gone_round(tmp_path: Path):
    out, kept = tmp_path / "run", tmp_path / "kept"
    slab = {"id": "slab", "category": "other", "size_m": [0.1, 0.7, 0.065]}
    scene = room(tmp_path, slab)
    summary = demo(out, scene, "--sensor", "bumper", "--record", str(kept))
    assert summary["success"], summary
    met = told(out, "met")
    assert met
    assert {line["touch"] for line in met} == {"bumper"}
    assert told(out, "end")[-1]["halts"]["bumper"] >= 1
    assert replayed(kept).startswith("equal in ")


def test_with_a_laser_glass_is_gone_round_and_not_into(tmp_path: Path):
    out, kept = tmp_path / "run", tmp_path / "kept"
    glass = {"id": "glass", "category": "mirror", "size_m": [0.05, 1.2, 1.5]}
    scene = room(tmp_path, glass)
    blind = "--noise", "none", "--noise", "glass=1.0"
    summary = demo(out, scene, "--sensor", "laser", *blind, "--record", str(kept))
    assert summary["success"], summary
    assert summary["collisions"] == 0
    assert replayed(kept).startswith("equal in ")


def test_a_drop_that_no_camera_sees_is_met_by_the_cliff_sensors_alone(tmp_path: Path):
    """It lies within what a level camera never sees of the floor round the start."""
    out, kept = tmp_path / "run", tmp_path / "kept"
    (x, y), wide = START_XY, 0.35
    hole = [[x + 0.6, y - wide], [x + 1.0, y - wide], [x + 1.0, y + wide], [x + 0.6, y + wide]]
    scene = room(tmp_path, hole=hole)
    summary = demo(out, scene, "--sensor", "cliffs", "--record", str(kept))
    assert summary["success"], summary
    assert {line["touch"] for line in told(out, "met")} == {"cliff"}
    assert told(out, "end")[-1]["halts"]["cliff"] >= 1
    assert replayed(kept).startswith("equal in ")


def test_with_a_low_battery_it_goes_back_to_where_it_began(tmp_path: Path):
    out = tmp_path / "run"
    low = "battery-low:at=9s,size=8"
    summary = demo(out, TESTS / "refs/flat.json", "--fault", low, goal="toilet")
    assert summary["reason"].startswith("battery: 8 % is left, battery.low_percent is 15; ")
    assert not summary["success"]
    end = told(out, "end")[-1]
    assert (end["state"], end["cause"]) == ("failed", "battery")
    steps = told(out, "step")
    assert sum(v**2 for v in steps[-1]["pose"][:2]) < 0.5**2
