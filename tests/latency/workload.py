"""What is timed: the stages of a frame over a drive of 640 x 480 images, by processes that take
turns frame by frame, so that whatever else the machine does it does to all of them. Times are of
the thread's own CPU.

  python workload.py IMAGES     serves frames: {"frame": n, "slow": share} in, times by stage out
"""

import json
import sys
import time
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from runtime import navigate
from runtime.core.mapping.solid_depth import solid
from runtime.core.motion.velocity_policy import steer
from runtime.core.types import (
    Ballot,
    Brief,
    Detections,
    Intrinsics,
    Mount,
    Observation,
    Pose,
    Twist,
)
from runtime.core.world import World

MOUNT = Mount(0.0, 0.0, 0.88, 0.0)
CFG = navigate.NavigateConfig()
NAMES = tuple(f"thing {n}" for n in range(20))
STEERS = 10  # ticks of the control loop a frame


class Nobody:
    def ask(self, brief: Brief, by: None) -> Ballot:
        return Ballot()


def keep(path: Path, images: list[Observation]) -> None:
    """Images for the processes that are timed, whose code may be older than what made them."""
    poses = [(i.pose.x_m, i.pose.y_m, i.pose.yaw_rad) for i in images]
    depth, lens = np.stack([i.depth_m for i in images]), images[0].intrinsics
    np.savez(path, depth=depth, poses=poses, lens=list(vars(lens).values()))


def kept(path: Path) -> list[Observation]:
    """They have no colour: no stage that is timed looks at it."""
    with np.load(path) as file:
        depth, poses, lens = file["depth"], file["poses"], file["lens"]
    intrinsics = Intrinsics(*lens[:4].tolist(), *(int(n) for n in lens[4:]))
    dark = np.zeros((*depth.shape[1:], 3), np.uint8)
    return [
        Observation((n + 1) * 100_000_000, dark, depth[n], Pose(*poses[n].tolist()), intrinsics)
        for n in range(len(depth))
    ]


def detections() -> Detections:
    """20 boxes all over the image."""
    x, y = np.meshgrid(np.linspace(20, 560, 5), np.linspace(120, 380, 4))
    x, y = x.ravel(), y.ravel()
    boxes = np.stack([x, y, x + 70, y + 60], axis=1).astype(np.float32)
    n, nothing = len(boxes), np.zeros(0, np.float32)
    likes, labels = np.eye(n, 32, dtype=np.float32), np.arange(n, dtype=np.int32)
    return Detections(boxes, np.full(n, 0.6, np.float32), labels, likes, nothing, nothing)


class Timed:
    """Drives through the images, one when it is asked for."""

    def __init__(self, images: list[Observation]) -> None:
        self._images, self._boxes = images, detections()
        self._world = self._begun()
        self._times: dict[str, float] = {}
        self._slow = 0.0

    def frame(self, n: int, slow: float) -> Mapping[str, float]:
        """CPU seconds by stage. `slow`: that share of them again is spent on nothing."""
        if n == 0:
            self._world = self._begun()
        obs, world, cfg, radius_m = self._images[n], self._world, CFG, CFG.robot.radius_m
        self._slow = slow
        self._stage("prepare", lambda: solid(obs.depth_m))
        outline = self._stage("survey", lambda: navigate.survey(world, obs, MOUNT, cfg))
        self._stage("place", lambda: navigate.place(world, obs, self._boxes, outline, MOUNT, cfg))
        snap = self._stage("decide", lambda: navigate.snapshot(world, "timed", cfg))
        navigate.adopt(world, navigate.decide(snap, Nobody(), None, cfg))
        course = self._stage("act", lambda: navigate.act(world, cfg)).course

        def ticks() -> None:
            for _ in range(STEERS):
                steer(course, obs.pose, Twist(0.3, 0.1), 0.05, radius_m, cfg.control, 0.3)

        self._stage("steer", ticks)
        return self._times

    def _begun(self) -> World:
        return World.begin(NAMES[3], NAMES, (), self._images[0].pose, CFG.robot.radius_m)

    def _stage(self, name: str, work: Callable[[], Any]) -> Any:
        began = time.thread_time()
        result = work()
        by = began + (time.thread_time() - began) * (1 + self._slow)
        while time.thread_time() < by:
            pass
        self._times[name] = time.thread_time() - began
        return result


def serve(path: Path) -> None:
    """Until the input ends."""
    cv2.setNumThreads(1)
    timed = Timed(kept(path))
    for line in sys.stdin:
        asked = json.loads(line)
        print(json.dumps(timed.frame(asked["frame"], asked["slow"])), flush=True)


if __name__ == "__main__":
    serve(Path(sys.argv[1]))
