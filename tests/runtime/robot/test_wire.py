"""Messages survive the way to bytes and back; damaged ones end in SensorError and nothing else."""

import math
import re
from collections.abc import Callable
from contextlib import suppress

import numpy as np
import pytest
from damaged import damaged
from hypothesis import assume, given
from hypothesis import strategies as st
from other_half import slam_pose, stamped_twist, tf

from runtime.core.types import Intrinsics, Pose
from runtime.errors import SensorError
from runtime.robot import wire
from runtime.robot.bounds import check_size

STAMPS = st.integers(0, (2**31 - 1) * 10**9 + 999_999_999)
POSES = st.builds(
    Pose,
    st.floats(-1e4, 1e4),
    st.floats(-1e4, 1e4),
    st.floats(-math.pi, math.pi, exclude_min=True),
)
DECODERS: list[Callable[[bytes, str], object]] = [
    wire.peek_stamp,
    wire.decode_camera_info,
    wire.decode_transforms,
    wire.decode_json,
    wire.decode_twist,
]
INTRINSICS = Intrinsics(388.2, 388.2, 320.0, 240.0, 640, 480)
SAMPLES = [
    wire.encode_camera_info(INTRINSICS, 1),
    wire.encode_odometry(Pose(1, 2, 0.5), 1),
    slam_pose(Pose(1, 2, 0.5), 1),
    tf(("base_link", "camera", (0, 0, 1), (0, 0, 0, 1))),
    wire.encode_json({"a": 1}),
    wire.encode_twist(0.1, 0.2),
]


@given(
    st.floats(0.1, 50), st.floats(0.1, 50), st.floats(-0.9, 1.9), st.floats(-0.9, 1.9),
    st.integers(8, 8192), st.integers(8, 8192),
)  # fmt: skip
def test_camera_info_round_trip(fx: float, fy: float, cx: float, cy: float, w: int, h: int) -> None:
    assume(0.1 <= fx * w / w <= 50 and 0.1 <= fy * h / h <= 50)  # not by a rounding less
    intrinsics = Intrinsics(fx * w, fy * h, cx * w, cy * h, w, h)
    assert wire.decode_camera_info(wire.encode_camera_info(intrinsics, 3), "i").value == intrinsics


@given(st.dictionaries(st.text(), st.one_of(st.integers(), st.text(), st.booleans(), st.none())))
def test_json_round_trip(value: dict[str, object]) -> None:
    assert wire.decode_json(wire.encode_json(value), "state") == value


@given(st.floats(-5, 5), st.floats(-5, 5))
def test_twist_round_trip(forward: float, turn: float) -> None:
    assert wire.decode_twist(wire.encode_twist(forward, turn), "cmd_vel") == (forward, turn)


def test_a_camera_without_intrinsics_is_named_with_the_remedy() -> None:
    payload = wire.encode_camera_info(Intrinsics(0, 0, 0, 0, 640, 480), 0)
    with pytest.raises(SensorError) as caught:
        wire.decode_camera_info(payload, "camera/color/camera_info")
    assert str(caught.value) == (
        "camera/color/camera_info: K is zero: camera without intrinsics; publish calibrated K"
    )


def test_a_skewed_k_is_no_pinhole() -> None:
    message = wire.decode(wire.encode_camera_info(INTRINSICS, 0), wire.CAMERA_INFO, "")
    message.k = np.array([300.0, 3, 320, 0, 300, 240, 0, 0, 1])
    with pytest.raises(SensorError, match=r"^cam/info: K = .* is not a pinhole matrix"):
        wire.decode_camera_info(wire.encode(message), "cam/info")


def test_sizes_that_contradict_are_both_named() -> None:
    with pytest.raises(SensorError, match=r"depth: image is 320x240 but info describes 640x480"):
        check_size((240, 320), "depth", INTRINSICS, "info")
    check_size((480, 640, 3), "color", INTRINSICS, "info")


@pytest.mark.parametrize(
    ("payload", "decode", "wanted"),
    [
        (wire.encode_twist(math.inf, 0), wire.decode_twist, "not finite"),
    ],
)
def test_contradictions_are_explained(
    payload: bytes, decode: Callable[[bytes, str], object], wanted: str
) -> None:
    with pytest.raises(SensorError, match=wanted) as caught:
        decode(payload, "some/topic")
    assert str(caught.value).startswith("some/topic: ")
    assert "\n" not in str(caught.value)


def _only_sensor_errors(payload: bytes) -> None:
    for decode in DECODERS:
        with suppress(SensorError):
            decode(payload, "some/topic")


@given(st.binary(max_size=400))
def test_random_bytes_raise_nothing_but_sensor_errors(payload: bytes) -> None:
    _only_sensor_errors(payload)
    _only_sensor_errors(b"\0\1\0\0" + payload)


@given(damaged(SAMPLES))
def test_damaged_messages_raise_nothing_but_sensor_errors(payload: bytes) -> None:
    _only_sensor_errors(payload)


@given(v=st.floats(-2, 2), w=st.floats(-3, 3), stamp=st.integers(0, 2**60))
def test_a_stamped_twist_survives_the_wire(v: float, w: float, stamp: int) -> None:
    assert stamped_twist(wire.encode_twist_stamped(v, w, stamp)) == (stamp, v, w)


def test_transforms_are_read_without_slashes_and_refused_when_not_finite() -> None:
    payload = tf(("/base_link", "head", (1, 2, 3), (0, 0, 0.6, 0.8)), stamp_ns=7)
    (one,) = wire.decode_transforms(payload, "tf")
    assert isinstance(one, wire.FrameTransform)
    assert (one.parent, one.child, one.stamp_ns) == ("base_link", "head", 7)
    np.testing.assert_allclose(one.translation_m, (1, 2, 3))
    np.testing.assert_allclose(one.quaternion, (0, 0, 0.6, 0.8))
    for at, q in (((math.nan, 0, 0), (0, 0, 0, 1)), ((0, 0, 0), (0, 0, 0, 0))):
        (wrong,) = wire.decode_transforms(tf(("base_link", "head", at, q)), "tf")
        assert isinstance(wrong, SensorError)
        assert re.match(r"^tf: head at .*: publish finite", str(wrong))
