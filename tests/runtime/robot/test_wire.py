"""Messages survive the way to bytes and back; damaged ones end in SensorError and nothing else."""

import math
import re
import struct
from collections.abc import Callable
from contextlib import suppress

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from other_half import compressed_color, slam_pose, stamped_twist, tf

from runtime.core.types import Intrinsics, Pose
from runtime.errors import SensorError
from runtime.robot import wire
from runtime.robot.bounds import check_size

STAMPS = st.integers(0, (2**31 - 1) * 10**9 + 999_999_999)
SIZES = st.tuples(st.integers(1, 9), st.integers(1, 9))
POSES = st.builds(
    Pose,
    st.floats(-1e4, 1e4),
    st.floats(-1e4, 1e4),
    st.floats(-math.pi, math.pi, exclude_min=True),
)
DECODERS: list[Callable[[bytes, str], object]] = [
    wire.peek_stamp,
    wire.decode_color,
    wire.decode_compressed_color,
    wire.decode_depth,
    wire.decode_camera_info,
    wire.decode_odometry,
    wire.decode_pose,
    wire.decode_transforms,
    wire.decode_json,
    wire.decode_twist,
]
INTRINSICS = Intrinsics(388.2, 388.2, 320.0, 240.0, 640, 480)
SAMPLES = [
    wire.encode_color(np.zeros((3, 4, 3), np.uint8), 1),
    compressed_color(np.zeros((3, 4, 3), np.uint8), 1),
    wire.encode_depth(np.ones((3, 4), np.float32), 1),
    wire.encode_camera_info(INTRINSICS, 1),
    wire.encode_odometry(Pose(1, 2, 0.5), 1),
    slam_pose(Pose(1, 2, 0.5), 1),
    tf(("base_link", "camera", (0, 0, 1), (0, 0, 0, 1))),
    wire.encode_json({"a": 1}),
    wire.encode_twist(0.1, 0.2),
]


@given(
    SIZES.flatmap(lambda s: hnp.arrays(np.uint8, (*s, 3))),
    STAMPS,
    st.sampled_from(["rgb8", "bgr8"]),
)
def test_colour_round_trip(rgb: np.ndarray, stamp_ns: int, encoding: str) -> None:
    payload = wire.encode_color(rgb, stamp_ns, encoding=encoding)
    got = wire.decode_color(payload, "color")
    assert got.stamp_ns == stamp_ns == wire.peek_stamp(payload, "color")
    np.testing.assert_array_equal(got.value, rgb)


@given(
    SIZES.flatmap(lambda s: hnp.arrays(np.float32, s, elements=st.floats(0, 60, width=32))), STAMPS
)
def test_depth_round_trip_in_both_units(depth: np.ndarray, stamp_ns: int) -> None:
    got = wire.decode_depth(wire.encode_depth(depth, stamp_ns), "depth")
    np.testing.assert_array_equal(got.value, depth)
    assert got.value.dtype == np.float32
    got = wire.decode_depth(wire.encode_depth(depth, stamp_ns, encoding="16UC1"), "depth")
    np.testing.assert_allclose(got.value, depth, atol=0.00051)
    assert got.stamp_ns == stamp_ns


def test_depth_without_a_reading_is_zero() -> None:
    raw = np.array([[np.nan, np.inf, -1.0, 2.0]], np.float32)
    for encoding in ("32FC1", "16UC1"):
        got = wire.decode_depth(wire.encode_depth(raw, 0, encoding=encoding), "depth")
        assert got.value.tolist() == [[0, 0, 0, 2]]


def _raw_image(encoding: str, big: int, step: int, size: tuple[int, int], data: bytes) -> bytes:
    width, height = size
    message = wire._T[wire.IMAGE](
        wire.header(7, "c"), height, width, encoding, big, step, np.frombuffer(data, np.uint8)
    )
    return wire.encode(message)


def test_rows_may_be_padded_and_words_big_endian() -> None:
    data = struct.pack(">HHxx", 1000, 2500) + struct.pack(">HHxx", 65535, 65534)
    got = wire.decode_depth(_raw_image("16UC1", 1, 6, (2, 2), data), "depth")
    np.testing.assert_allclose(got.value, [[1.0, 2.5], [0.0, 65.534]])
    got = wire.decode_depth(_raw_image("32FC1", 1, 4, (1, 1), struct.pack(">f", 1.5)), "depth")
    assert got.value.tolist() == [[1.5]]
    colour = wire.decode_color(_raw_image("bgr8", 0, 4, (1, 2), b"\1\2\3x\4\5\6x"), "color")
    assert colour.value.tolist() == [[[3, 2, 1]], [[6, 5, 4]]]


@given(POSES, STAMPS)
def test_odometry_and_pose_round_trip(pose: Pose, stamp_ns: int) -> None:
    for got in (
        wire.decode_odometry(wire.encode_odometry(pose, stamp_ns), "odom"),
        wire.decode_pose(slam_pose(pose, stamp_ns), "pose"),
    ):
        assert got.stamp_ns == stamp_ns
        assert (got.value.x_m, got.value.y_m) == (pose.x_m, pose.y_m)
        assert abs(math.remainder(got.value.yaw_rad - pose.yaw_rad, math.tau)) < 1e-9
        assert -math.pi < got.value.yaw_rad <= math.pi


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


def test_compressed_colour_comes_back_as_rgb() -> None:
    rgb = np.full((16, 16, 3), (200, 100, 20), np.uint8)
    got = wire.decode_compressed_color(compressed_color(rgb, 9), "color/compressed")
    assert got.stamp_ns == 9
    np.testing.assert_allclose(got.value.astype(int), rgb, atol=6)


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
        (_raw_image("yuv422", 0, 4, (2, 1), b"1234"), wire.decode_color, "publish rgb8 or bgr8"),
        (_raw_image("rgb8", 0, 6, (2, 1), b"123456"), wire.decode_depth, "publish 16UC1"),
        (_raw_image("rgb8", 0, 5, (2, 1), b"123456"), wire.decode_color, "needs step >= 6"),
        (_raw_image("rgb8", 0, 6, (2, 2), b"123456"), wire.decode_color, "got step 6 and 6 bytes"),
        (_raw_image("rgb8", 0, 6, (0, 2), b""), wire.decode_color, "0x2 pixels"),
        (wire.encode_odometry(Pose(math.nan, 0, 0), 0), wire.decode_odometry, "finite"),
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


@given(st.sampled_from(SAMPLES), st.data())
def test_damaged_messages_raise_nothing_but_sensor_errors(
    sample: bytes, data: st.DataObject
) -> None:
    damaged = bytearray(sample)
    for _ in range(data.draw(st.integers(1, 4))):
        damaged[data.draw(st.integers(0, len(sample) - 1))] = data.draw(st.integers(0, 255))
    end = data.draw(st.integers(0, len(sample)))
    _only_sensor_errors(bytes(damaged))
    _only_sensor_errors(bytes(damaged[:end]))


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
