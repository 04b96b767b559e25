"""Success by protocol, and its variants."""

import math
import pickle
from dataclasses import replace

import numpy as np
import pytest

from hil_sim.simulation.noise import NONE, USUAL
from hil_sim.simulation.protocol import PROTOCOLS, Ending, GoalSighting, protocol_named
from runtime import config
from runtime.errors import ConfigError
from runtime.robot import wire
from runtime.robot.images.reading import decode_depth


def test_robothor_needs_the_target_in_view_and_near() -> None:
    good = GoalSighting(pixels=100, depth_m=1.2, box_m=1.0)
    success = PROTOCOLS["robothor"].success
    assert success(Ending(True, math.inf, (good,)))
    assert not success(Ending(False, 0.0, (good,)))
    assert not success(Ending(True, 0.0, (GoalSighting(99, 0.5, 0.5),)))
    assert not success(Ending(True, 0.0, (GoalSighting(5000, 1.2, 1.01),)))
    # One near and unseen, another seen and far: neither is found.
    assert not success(
        Ending(True, 0.0, (GoalSighting(0, math.inf, 0.3), GoalSighting(900, 3.0, 3.0)))
    )


def test_onrobot_is_as_hm3d_with_room_to_brake() -> None:
    success = PROTOCOLS["onrobot"].success
    assert success(Ending(True, 0.25))
    assert not success(Ending(True, 0.26))
    assert not success(Ending(False, 0.0))


def test_cameras_and_time() -> None:
    hm3d, robothor, onrobot = (PROTOCOLS[name] for name in ("hm3d", "robothor", "onrobot"))
    assert (hm3d.camera_z_m, robothor.camera_z_m) == (0.88, 0.87)
    assert robothor.intrinsics == hm3d.intrinsics
    assert robothor.depth_max_m == math.inf
    assert onrobot.max_steps * onrobot.observe_s == 300
    assert hm3d.noise == NONE
    assert (robothor.noise.motion, robothor.noise.depth) == (1.0, 0.0)
    assert onrobot.noise.depth == USUAL.depth


def test_tilt_noise_and_extras() -> None:
    tilted = protocol_named("robothor", "episode", ["motion=0", "drift=0.01"], ["laser"])
    assert tilted.tilt_rad == pytest.approx(math.radians(30))
    assert (tilted.noise.motion, tilted.noise.drift) == (0.0, 0.01)
    assert (tilted.laser, tilted.bumper) == (True, False)


@pytest.mark.parametrize("name", list(PROTOCOLS))
def test_the_runtime_takes_a_protocols_settings(name: str) -> None:
    read = config.load(None, PROTOCOLS[name].settings)
    assert read.camera.z_m == PROTOCOLS[name].camera_z_m
    tilted = config.load(None, protocol_named("robothor", "episode").settings)
    assert tilted.camera.pitch_rad == pytest.approx(math.radians(30))


def test_protocols_travel_to_other_processes() -> None:
    for protocol in PROTOCOLS.values():
        assert pickle.loads(pickle.dumps(protocol)) == protocol


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (("hm4d",), "protocol hm4d: unknown; known: hm3d, onrobot, robothor"),
        (("hm3d", "episode"), "tilt episode: protocol hm3d's camera is level; use robothor"),
        (("hm3d", "down"), "tilt down: must be level or episode"),
        (("hm3d", "level", ["x"]), "noise x: unknown"),
        (("hm3d", "level", [], ["lidar"]), "sensor lidar: unknown; known: laser, bumper, cliffs"),
    ],
)
def test_what_is_wrong_is_named(arguments: tuple[object, ...], says: str) -> None:
    with pytest.raises(ConfigError, match=says):
        protocol_named(*arguments)  # type: ignore[arg-type]


def test_depth_in_whole_millimetres_is_what_16_bits_hold() -> None:
    depth_m = np.random.default_rng(0).uniform(0.0, 8.0, (30, 40)).astype(np.float32)
    sensed = replace(PROTOCOLS["hm3d"], whole_mm=True).sensed(depth_m)
    told = decode_depth(wire.encode_depth(sensed, 0, encoding="16UC1"), "depth")
    assert np.array_equal(told.value, sensed)
    assert np.abs(sensed - PROTOCOLS["hm3d"].sensed(depth_m)).max() <= 0.00051
