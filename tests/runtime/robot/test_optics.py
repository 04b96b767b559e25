"""Images as they are handed on: upright, straight, depth in colour's pixels, and where the camera
that took them is."""

import math

import numpy as np
import pytest
from bent_lens import directions, painted
from other_half import camera_info, tf

from runtime.core.geometry import optical_rays, optical_to_base
from runtime.core.optics.upright import upright_mount
from runtime.core.types import F32, Intrinsics, Mount
from runtime.errors import SensorError
from runtime.robot.optics import Optics, info_topic
from runtime.robot.session import TopicsConfig
from runtime.robot.sync import RawMessage
from runtime.robot.transforms import CameraConfig, Transforms, UnplacedError

COLOR = Intrinsics(150.0, 150.0, 80.0, 60.0, 160, 120)
DEPTH = Intrinsics(105.0, 105.0, 84.0, 50.0, 168, 100)
MINE, OTHER = "color_optical", "depth_optical"
OPTICAL = (-0.5, 0.5, -0.5, 0.5)  # x y z w, of an optical frame in a body's
OFFSET = (-0.05, 0.0, 0.0)  # of the depth camera in colour's optical frame
HALF = math.sqrt(0.5)


def optics(
    config: CameraConfig, *transforms: bytes, depth: Intrinsics | None = None, **color: object
) -> Optics:
    """Of cameras that have told of themselves; what of `color` is more than a pinhole."""
    told = Transforms(lambda error: pytest.fail(str(error)))
    for payload in transforms:
        told.file("tf_static", payload)
    topics = TopicsConfig(color="c/image", depth="d/image", camera_info="c/camera_info")
    made = Optics(config, topics, told, lambda topic, error: pytest.fail(str(error)))
    for info, camera, frame in ((made.color, COLOR, MINE), (made.depth, depth, OTHER)):
        if camera is not None:
            k = camera.fx, camera.fy, camera.cx, camera.cy
            more = color if frame == MINE else {}
            payload = camera_info((camera.width, camera.height), k, frame=frame, **more)
            info.file(RawMessage(0, payload, 0.0))
            info.read()
    return made


def floor(camera: Intrinsics, mount: Mount) -> F32:
    """(H, W) m of an endless floor; 0 above the horizon."""
    up = (optical_rays(camera, 1) @ optical_to_base(mount).T)[..., 2]
    with np.errstate(divide="ignore"):
        depth = np.where(up < -0.05, mount.z_m / -up, 0.0)
    return depth.astype(np.float32)


def heights(depth_m: F32, camera: Intrinsics, mount: Mount) -> np.ndarray:
    """Above the floor, of all readings."""
    rays = optical_rays(camera, 1) @ optical_to_base(mount).T
    return (mount.z_m + depth_m * rays[..., 2])[depth_m > 0]


RGB = painted(*directions(COLOR))


def test_an_aligned_upright_camera_is_handed_on_as_it_came():
    depth = floor(COLOR, Mount(pitch_rad=0.4))
    pair = optics(CameraConfig()).pair(RGB, depth, MINE, 0)
    assert pair.rgb is RGB
    assert pair.depth_m is depth
    assert (pair.intrinsics, pair.mount, pair.altered) == (COLOR, None, False)


@pytest.mark.parametrize("turned", [1, 2, 3])
def test_a_turned_camera_by_configuration(turned: int):
    config = CameraConfig(roll_rad=turned * math.pi / 2 + 0.1, pitch_rad=0.4, x_m=0.1)
    made, depth = optics(config), floor(COLOR, config)
    pair, sight = made.pair(RGB, depth, MINE, 0), made.sight(depth, MINE, 0)
    upright = upright_mount(config)
    assert abs(math.remainder(upright.roll_rad - 0.1, math.tau)) < 1e-9
    for depth_m, intrinsics, mount in (
        (pair.depth_m, pair.intrinsics, upright),
        (sight.depth_m, sight.intrinsics, sight.mounted(config)),
    ):
        np.testing.assert_allclose(heights(depth_m, intrinsics, mount), 0, atol=2e-3)
        assert depth_m.flags.c_contiguous
    assert pair.rgb.shape[:2] == pair.depth_m.shape
    assert pair.altered


def test_a_turned_camera_by_tf_that_is_not_gone_by_otherwise():
    body = tf(
        ("base_link", "mast", (0.2, 0, 1.1), (HALF, 0, 0, HALF)), ("mast", MINE, (0, 0, 0), OPTICAL)
    )
    made = optics(CameraConfig(z_m=0.9, pitch_rad=0.4), body)
    taken = floor(COLOR, Mount(z_m=0.9, pitch_rad=0.4, roll_rad=math.pi / 2))
    pair = made.pair(RGB, taken, MINE, 0)
    assert pair.rgb.shape == (160, 120, 3)
    mount = Mount(z_m=0.9, pitch_rad=0.4)
    np.testing.assert_allclose(heights(pair.depth_m, pair.intrinsics, mount), 0, atol=2e-3)


def test_where_tf_is_gone_by_it_says_how_the_camera_is_turned():
    # Its right points down, its down to the left: it leans to the right by a quarter.
    body = tf(("base_link", MINE, (0.2, 0.0, 1.1), (0.0, HALF, 0.0, HALF)))
    made = optics(CameraConfig(mount="tf"), body)
    pair = made.pair(RGB, np.ones((120, 160), np.float32), MINE, 0)
    assert pair.mount == Mount(0.2, 0.0, 1.1)
    assert (pair.intrinsics.width, pair.intrinsics.height) == (120, 160)


def test_a_frame_that_is_no_optical_one_turns_nothing():
    pitch = 0.7  # of a body's frame, x ahead, by which drivers of simulated cameras call images
    body = tf(("base_link", MINE, (0, 0, 1), (0, math.sin(pitch / 2), 0, math.cos(pitch / 2))))
    made, depth = optics(CameraConfig(pitch_rad=pitch), body), np.ones((120, 160), np.float32)
    assert made.pair(RGB, depth, MINE, 0).rgb is RGB
    assert made.sight(depth, MINE, 0).depth_m is depth


def test_a_turned_camera_stays_turned_where_tf_comes_late_for_an_image_or_it_looks_down():
    made, depth = optics(CameraConfig()), np.ones((120, 160), np.float32)
    told = made._transforms
    told.file("tf_static", tf(("mast", MINE, (0, 0, 0), OPTICAL)))
    for second, pitch in ((1, 0.0), (3, 1.2)):
        about = (HALF * math.cos(pitch / 2), HALF * math.sin(pitch / 2))
        turned = (about[0], about[1], -about[1], about[0])  # leans, then nods
        told.file("tf", tf(("base_link", "mast", (0, 0, 1), turned), stamp_ns=second * 10**9))
    for second in (1, 2, 3):
        assert made.pair(RGB, depth, MINE, second * 10**9).rgb.shape == (160, 120, 3)
        assert made.sight(depth, MINE, second * 10**9).depth_m.shape == (160, 120)


def test_the_reflex_sees_where_tf_tells_of_the_colour_camera_alone():
    body = tf(("base_link", MINE, (0.2, 0.0, 1.1), OPTICAL))
    config = CameraConfig(mount="tf", depth_at=(0.0, 0.05, 0.0, 0.0, 0.0, 0.0))
    sight = optics(config, body, depth=DEPTH).sight(floor(DEPTH, Mount(z_m=1.1)), OTHER, 0)
    assert sight.mount == Mount(0.2, 0.05, 1.1)


def test_where_colour_tells_no_frame_the_camera_is_where_depth_s_is():
    body = tf(("base_link", OTHER, (0.2, 0.0, 1.1), OPTICAL))
    made, told = optics(CameraConfig(mount="tf"), body, depth=DEPTH), Mount(0.2, 0.0, 1.1)
    made.color.frame = ""
    depth = floor(DEPTH, told)
    assert made.pair(RGB, depth, OTHER, 0).mount == told
    assert made.sight(depth, OTHER, 0).mount == told


def test_a_bent_lens_is_straightened_in_colour_and_depth():
    bent = (-0.25, 0.06, 0.0, 0.0, 0.0)
    made = optics(CameraConfig(), distortion=bent)
    taken = painted(*directions(COLOR, "plumb_bob", bent))
    pair = made.pair(taken, np.full((120, 160), 2.0, np.float32), MINE, 0)
    off = np.abs(pair.rgb.astype(int) - RGB)[pair.rgb.any(axis=2)]
    assert np.quantile(off, 0.99) <= 3
    assert pair.altered
    assert set(np.unique(pair.depth_m)) <= {0.0, 2.0}


def beside() -> bytes:
    return tf((MINE, OTHER, OFFSET, (0, 0, 0, 1)))


@pytest.mark.parametrize("turned", [0, 1, 2])
@pytest.mark.parametrize("told_by", ["tf", "key"])
def test_depth_of_another_camera_is_put_into_colour_s_pixels(turned: int, told_by: str):
    config = CameraConfig(z_m=0.9, pitch_rad=0.5, roll_rad=turned * math.pi / 2)
    by_key = CameraConfig(**vars(config) | {"depth_at": (0.0, 0.05, 0.0, 0.0, 0.0, 0.0)})
    made = optics(config, beside(), depth=DEPTH) if told_by == "tf" else optics(by_key, depth=DEPTH)
    turn = optical_to_base(config)
    there = turn @ OFFSET + (config.x_m, config.y_m, config.z_m)
    own = Mount(*there, config.roll_rad, config.pitch_rad, config.yaw_rad)
    taken = floor(DEPTH, own)
    pair, sight = made.pair(RGB, taken, OTHER, 0), made.sight(taken, OTHER, 0)
    wanted = floor(pair.intrinsics, upright_mount(config))
    told = (pair.depth_m > 0) & (wanted > 0) & (wanted < 6)
    assert told.sum() > 3000
    error = np.abs(pair.depth_m[told] / wanted[told] - 1)
    assert np.quantile(error, 0.98) < 0.03
    assert pair.depth_m.shape == pair.rgb.shape[:2]
    upright = sight.mounted(config)  # the reflex sees by the depth camera's own place
    assert upright.z_m == pytest.approx(own.z_m, abs=1e-3)
    np.testing.assert_allclose(heights(sight.depth_m, sight.intrinsics, upright), 0, atol=4e-3)


def test_depth_of_an_unknown_frame_is_refused_in_a_line_with_both_frames():
    made, depth = optics(CameraConfig(), depth=DEPTH), np.ones((100, 168), np.float32)
    for ask in (lambda: made.pair(RGB, depth, OTHER, 0), lambda: made.sight(depth, OTHER, 0)):
        with pytest.raises(UnplacedError) as caught:
            ask()
        assert str(caught.value) == (
            f"d/image: is of frame {OTHER}, c/camera_info of {MINE}, and tf does not relate them: "
            "publish depth registered to colour (align_depth), or set camera.depth_at"
        )


def test_depth_of_another_camera_without_intrinsics_is_refused():
    made = optics(CameraConfig(), beside())
    with pytest.raises(SensorError, match=r"nothing tells its intrinsics: publish d/camera_info"):
        made.pair(RGB, np.ones((120, 160), np.float32), OTHER, 0)


def test_six_zeros_say_that_depth_is_colour_s_whatever_its_frame_is_called():
    made = optics(CameraConfig(depth_at=(0.0,) * 6))
    depth = np.ones((120, 160), np.float32)
    assert made.pair(RGB, depth, OTHER, 0).depth_m is depth


def test_depth_of_the_same_view_in_fewer_pixels_is_taken_to_colour_s():
    small = Intrinsics(75.0, 75.0, 40.0, 30.0, 80, 60)
    taken = floor(small, Mount(pitch_rad=0.5))
    for more in ({}, {"depth": small}):
        pair = optics(CameraConfig(), **more).pair(RGB, taken, MINE, 0)
        assert pair.depth_m.shape == (120, 160)
        assert pair.intrinsics == COLOR
        found = heights(pair.depth_m, COLOR, Mount(pitch_rad=0.5))
        assert np.quantile(np.abs(found), 0.95) < 0.02
        sight = optics(CameraConfig(), **more).sight(taken, MINE, 0)
        assert sight.intrinsics == small
        np.testing.assert_allclose(
            heights(sight.depth_m, small, Mount(pitch_rad=0.5)), 0, atol=1e-3
        )


def test_depth_of_another_view_in_the_same_frame_is_registered():
    made = optics(CameraConfig(), depth=DEPTH)
    mount = Mount(pitch_rad=0.5)
    pair = made.pair(RGB, floor(DEPTH, mount), MINE, 0)
    wanted = floor(COLOR, mount)
    told = (pair.depth_m > 0) & (wanted > 0) & (wanted < 6)
    assert np.quantile(np.abs(pair.depth_m[told] / wanted[told] - 1), 0.98) < 0.03


def test_sizes_that_nothing_explains_are_refused():
    with pytest.raises(SensorError, match="d/image: image is 168x100 but c/camera_info"):
        optics(CameraConfig()).pair(RGB, np.ones((100, 168), np.float32), MINE, 0)
    with pytest.raises(SensorError, match="c/image: image is 160x100"):
        optics(CameraConfig()).pair(RGB[:100], np.ones((120, 160), np.float32), MINE, 0)


def test_before_the_intrinsics_there_is_no_sight():
    none = Transforms(lambda error: None)
    made = Optics(CameraConfig(), TopicsConfig(), none, lambda topic, error: None)
    assert made.sight(np.ones((120, 160), np.float32), MINE, 0) is None


@pytest.mark.parametrize(
    ("images", "info"),
    [
        ("camera/depth/image_raw", "camera/depth/camera_info"),
        ("camera/depth/image_raw/compressedDepth", "camera/depth/camera_info"),
        ("depth", "camera_info"),
    ],
)
def test_a_driver_tells_of_a_camera_beside_its_images(images: str, info: str):
    assert info_topic(images) == info
