"""What is noted of an episode, against what was put in."""

import json
import math
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hil_sim.ground_truth.true_labels import true_labels
from hil_sim.ground_truth.witness import Witness, box_distance_m, standing_at, to_scene
from hil_sim.scenes.format import Room, Scene, SceneObject
from hil_sim.simulation.robot import Robot
from runtime.core.types import Pose

UNIT = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
POSES = st.builds(Pose, st.floats(-9, 9), st.floats(-9, 9), st.floats(-3.1, 3.1))


@given(st.floats(-3, 3), st.floats(-3, 3))
def test_distance_to_a_box(x: float, y: float) -> None:
    wanted = math.hypot(max(-x, 0.0, x - 1), max(-y, 0.0, y - 1))
    assert box_distance_m(UNIT, x, y) == pytest.approx(wanted, abs=1e-9)


@given(POSES, POSES)
def test_points_of_a_drifted_map_come_to_where_they_are(truth: Pose, reported: Pose) -> None:
    moved = to_scene(truth, reported)
    assert moved(reported.x_m, reported.y_m) == pytest.approx((truth.x_m, truth.y_m))
    c, s = math.cos(reported.yaw_rad), math.sin(reported.yaw_rad)
    ahead = moved(reported.x_m + 2 * c, reported.y_m + 2 * s)
    c, s = math.cos(truth.yaw_rad), math.sin(truth.yaw_rad)
    assert ahead == pytest.approx((truth.x_m + 2 * c, truth.y_m + 2 * s), abs=1e-9)


@pytest.fixture
def witness(tmp_path: Path) -> Iterator[Witness]:
    made = Witness((2,), (UNIT,), lambda pose: abs(pose.x_m), tmp_path / "track.jsonl")
    yield made
    made.close()


def frame(pixels: int, depth_m: float) -> tuple[np.ndarray, np.ndarray]:
    seen = np.full(1000, -1, np.int32)
    seen[:pixels] = 2
    depth = np.full(1000, 9.0, np.float32)
    depth[:pixels] = depth_m
    whole = 480, 640
    seen, depth = np.pad(seen, (0, 306_200), constant_values=-1), np.pad(depth, (0, 306_200))
    return depth.reshape(whole), seen.reshape(whole)


def here(x: float, y: float) -> tuple[float, float]:
    return x, y


def test_seen_is_200_pixels_within_5_m(witness: Witness) -> None:
    at = Pose(3.0, 0.5, 0)
    for step, (pixels, depth) in enumerate([(199, 1.0), (999, 5.1), (0, 1.0), (200, 5.0)], 1):
        witness.look(step, at, *frame(pixels, depth))
    facts = witness.facts()
    assert (facts.seen_at, facts.seen_steps) == (4, 1)
    assert witness.sightings[0].pixels == 200
    assert witness.sightings[0].box_m == pytest.approx(2.0)
    witness.close()


def test_believed_and_claimed(witness: Witness) -> None:
    far, near = [1.6, 0.5], [1.4, 0.5]
    witness.hear(1, {"mode": "target", "toward_xy": far}, (), here)
    witness.hear(2, {"mode": "frontier", "toward_xy": near}, (), here)
    assert witness.facts().believed_at is None
    witness.hear(3, {"mode": "face", "toward_xy": near}, (), here)
    witness.hear(4, {"mode": "stop", "toward_xy": far}, (), here)
    facts = witness.facts()
    assert (facts.believed_at, facts.claim) == (3, "false")
    assert facts.actions == {"face": 1, "frontier": 1, "stop": 1, "target": 1}
    witness.hear(5, {"mode": "stop", "toward_xy": near}, (), here)
    assert witness.facts().claim == "true"
    witness.close()


def test_giving_up_claims_nothing(witness: Witness) -> None:
    witness.hear(1, {"mode": "stop", "toward_xy": None}, (), here)
    assert (witness.facts().claim, witness.facts().stands) == ("", ())
    witness.close()


THINGS = (
    ("table", 2 * UNIT),
    ("bowl", UNIT / 4 + 1),
    ("other", UNIT / 2),
    ("stool", np.array([3.0, 0.0]) + UNIT),
    ("other", np.array([0.0, 5.0]) + UNIT),
)


@pytest.mark.parametrize(
    ("xy", "stands"),
    [
        ((1.1, 1.1), ("bowl", "table")),
        ((1.6, 1.6), ("table",)),
        ((0.2, 0.2), ("table",)),  # what has no category stands on it
        ((2.6, 0.5), ("stool",)),  # in none, and nearer to it
        ((2.4, 0.5), ("table",)),
        ((0.5, 5.5), ("other",)),
        ((4.6, 0.5), ()),
    ],
)
def test_what_stands_at_a_point(xy: tuple[float, float], stands: tuple[str, ...]) -> None:
    assert standing_at(THINGS, *xy) == stands


def test_what_stands_where_it_claimed_the_goal(tmp_path: Path) -> None:
    witness = Witness((2,), (9 + UNIT,), lambda pose: 0.0, tmp_path / "track.jsonl", THINGS)
    witness.hear(1, {"mode": "target", "toward_xy": [3.5, 0.5]}, (), here)
    assert witness.facts().stands == ()
    witness.hear(2, {"mode": "stop", "toward_xy": [0.6, 2.6]}, (), lambda x, y: (y, x - 0.1))
    assert (witness.facts().claim, witness.facts().stands) == ("false", ("stool",))
    witness.close()


def test_frontier_distances_leave_out_what_cannot_be_measured(tmp_path: Path) -> None:
    witness = Witness(
        (), (), lambda pose: math.inf if pose.x_m > 5 else pose.x_m, tmp_path / "track.jsonl"
    )
    frontiers = [{"id": 4, "goal_xy": [2.0, 0.0]}, {"id": 5, "goal_xy": [7.0, 0.0]}]
    for elected in (4, 5, None, 9):
        witness.hear(1, {}, ({"frontier": elected, "frontiers": frontiers},), here)
    assert witness.facts().frontier_m == (2.0,)
    witness.close()


def test_the_track(witness: Witness, tmp_path: Path) -> None:
    witness.moved(Robot(Pose(1.00004, 2.0, 3.0)), "look", "turn_left", False)
    witness.moved(Robot(Pose(1.0, 2.0, 3.0)), "target", "move_forward", True)
    witness.close()
    rows = [json.loads(line) for line in (tmp_path / "track.jsonl").read_text().splitlines()]
    assert rows[0] == {
        "x": 1.0, "y": 2.0, "yaw": 3.0, "mode": "look", "action": "turn_left", "collided": False,
    }  # fmt: skip
    assert rows[1]["collided"]


def test_true_labels_name_what_shows_100_pixels() -> None:
    objects = tuple(
        SceneObject(name, name, "builtin:box", (0, 0, 0)) for name in ("bed", "sofa", "other")
    )
    rooms = (Room("r", "bedroom", ((0, 0), (2, 0), (2, 2), (0, 2))),)
    scene = Scene("s", (), (), rooms, objects)
    seen, depth = np.full((480, 640), -1, np.int32), np.full((480, 640), 3.0, np.float32)
    seen[10:20, 30:40], seen[0:9, 0:11], seen[30:40, :] = 0, 1, 2
    labels = true_labels(scene, Pose(1, 1, 0), seen, depth)
    assert (labels["boxes"], labels["names"]) == ([[30, 10, 40, 20]], ["bed"])
    assert (labels["scores"], labels["depths_m"], labels["room"]) == ([1.0], [3.0], "bedroom")
    assert true_labels(scene, Pose(5, 1, 0), seen, depth)["room"] is None
