"""The camera's place on the base, by a tree of frames."""

import math
from collections.abc import Callable

import numpy as np
import pytest
from other_half import tf

from runtime.errors import SensorError
from runtime.robot import wire
from runtime.robot.transforms import HELD_NS, RAW_KEPT, TF, TF_STATIC, Transforms, peek_frame

BASE, CAMERA = "base_link", "head_camera_optical"
UPRIGHT = (0.0, 0.0, 0.0, 1.0)
OPTICAL = (-0.5, 0.5, -0.5, 0.5)  # x right, y down, z ahead
S = 1_000_000_000


def tilted(pitch_rad: float) -> tuple[float, ...]:
    return (0.0, math.sin(pitch_rad / 2), 0.0, math.cos(pitch_rad / 2))


def nothing_bad(error: SensorError) -> None:
    raise error


def robot(bad: Callable[[SensorError], None] = nothing_bad) -> Transforms:
    """A mast on the base, a head that tilts on it, a camera that is told by its optical frame."""
    tree = Transforms(bad)
    tree.file(TF_STATIC, tf((BASE, "mast", (0.1, 0, 0.8), UPRIGHT)))
    tree.file(TF_STATIC, tf(("head", CAMERA, (0.05, 0.02, 0.1), OPTICAL)))
    return tree


def nod(tree: Transforms, pitch_rad: float, stamp_ns: int) -> None:
    tree.file(TF, tf(("mast", "head", (0, 0, 0), tilted(pitch_rad)), stamp_ns=stamp_ns))


def test_a_chain_of_frames_gives_the_mount_at_the_images_time() -> None:
    tree = robot()
    nod(tree, 0.2, 10 * S)
    nod(tree, 0.4, 10 * S + 200_000_000)
    mount = tree.mount(BASE, CAMERA, 10 * S + 100_000_000)
    assert mount.pitch_rad == pytest.approx(0.3, abs=1e-3)
    assert (mount.roll_rad, mount.yaw_rad) == pytest.approx((0, 0), abs=1e-3)
    assert mount.x_m == pytest.approx(0.1 + 0.05 * math.cos(0.3) + 0.1 * math.sin(0.3), abs=1e-3)
    assert mount.y_m == pytest.approx(0.02, abs=1e-3)
    assert mount.z_m == pytest.approx(0.8 - 0.05 * math.sin(0.3) + 0.1 * math.cos(0.3), abs=1e-3)


def test_a_base_frame_beside_the_cameras_branch_will_do() -> None:
    tree = robot()
    nod(tree, 0.0, 0)
    tree.file(TF_STATIC, tf(("base_footprint", BASE, (0, 0, 0.07), UPRIGHT)))
    tree.file(TF_STATIC, tf(("base_footprint", "wheel", (0, 0.2, 0.05), UPRIGHT)))
    assert tree.mount("base_footprint", CAMERA, 0).z_m == pytest.approx(0.97)
    assert tree.mount("wheel", CAMERA, 0).z_m == pytest.approx(0.92)


def test_the_newest_holds_for_a_while_and_no_longer() -> None:
    tree = robot()
    nod(tree, 0.1, 10 * S)
    assert tree.mount(BASE, CAMERA, 10 * S + HELD_NS).pitch_rad == pytest.approx(0.1, abs=1e-3)
    with pytest.raises(SensorError, match=r"^tf: head was told 2.00 s from the image's time"):
        tree.mount(BASE, CAMERA, 12 * S)


def test_a_clock_that_was_set_back_begins_anew() -> None:
    tree = robot()
    nod(tree, 0.1, 100 * S)
    nod(tree, 0.3, 5 * S)
    assert tree.mount(BASE, CAMERA, 5 * S).pitch_rad == pytest.approx(0.3, abs=1e-3)


def test_what_never_moves_is_not_pushed_out_by_what_does_while_nobody_asks() -> None:
    tree = robot()
    for n in range(RAW_KEPT + 1):
        nod(tree, 0.2, n * 10_000_000)
    assert tree.mount(BASE, CAMERA, RAW_KEPT * 10_000_000).pitch_rad == pytest.approx(0.2, abs=1e-3)


@pytest.mark.parametrize("pitch_rad", [-0.4, 0.0, 0.5, 0.9])
def test_a_body_s_frame_is_not_taken_for_an_optical_one(pitch_rad: float) -> None:
    tree = robot()
    nod(tree, pitch_rad, 0)
    with pytest.raises(SensorError, match=r"^tf: head looks .*set research.camera_frame to the op"):
        tree.mount(BASE, "head", 0)
    assert tree.mount(BASE, CAMERA, 0).pitch_rad == pytest.approx(pitch_rad, abs=1e-3)


def test_a_frame_whose_name_is_fit_for_no_line_is_told_of_and_the_rest_is_gone_on_with() -> None:
    found: list[str] = []
    tree = Transforms(lambda error: found.append(str(error)))
    names = ("good", "two\nlines", "n" * 1000)
    links = [(BASE, name, (0.0, 0.0, 1.0), OPTICAL) for name in names]
    tree.file(TF_STATIC, tf(*links))
    assert tree.mount(BASE, "good", 0).z_m == 1.0
    assert [line.isprintable() and len(line) < 200 for line in found] == [True, True]
    image = wire.encode_color(np.zeros((2, 2, 3), np.uint8), 7, "lens\x1b[2J")
    with pytest.raises(SensorError, match=r"^images: the frame .* can be printed"):
        peek_frame(image, "images")


def test_what_is_missing_is_named() -> None:
    tree = robot()
    with pytest.raises(SensorError, match=r"^tf: no way from base_link to head_camera_optical; "
                       r"known are head_camera_optical, mast: publish it"):  # fmt: skip
        tree.mount(BASE, CAMERA, 0)
    with pytest.raises(SensorError, match="known are nothing"):
        Transforms(nothing_bad).mount(BASE, CAMERA, 0)


def test_frames_in_a_circle_end_in_an_error() -> None:
    tree = Transforms(nothing_bad)
    tree.file(TF_STATIC, tf(("a", "b", (0, 0, 0), UPRIGHT), ("b", "a", (0, 0, 0), UPRIGHT)))
    with pytest.raises(SensorError, match="no way from base_link to a"):
        tree.mount(BASE, "a", 0)


def test_a_frame_that_is_not_optical_is_told() -> None:
    tree = Transforms(nothing_bad)
    tree.file(TF_STATIC, tf((BASE, "camera_link", (0, 0, 0.9), UPRIGHT)))
    with pytest.raises(SensorError, match=r"^tf: camera_link looks straight up: set"):
        tree.mount(BASE, "camera_link", 0)


def test_what_is_damaged_is_told_and_the_rest_goes_on() -> None:
    told: list[SensorError] = []
    tree = robot(told.append)
    for stamp_ns in (0, 1, 2):  # before every image one that is cut off, and a foreign wheel
        tree.file(TF, b"\x00\x01\x00\x00nonsense")
        tree.file(TF, tf((BASE, "wheel", (0, 0, 0), (0, 0, 0, 0)), stamp_ns=stamp_ns))
        nod(tree, 0.0, stamp_ns)
        assert tree.mount(BASE, CAMERA, stamp_ns).z_m == pytest.approx(0.9)
    assert len(told) == 6
    assert str(told[0]).startswith("tf: 12 bytes are not a CDR")
    assert "unit quaternions" in str(told[1])


def test_a_slash_in_a_configured_frame_is_none() -> None:
    tree = robot()
    nod(tree, 0.0, 0)
    assert tree.mount(f"/{BASE}", f"/{CAMERA}", 0) == tree.mount(BASE, CAMERA, 0)


def test_the_frame_is_read_without_the_rest() -> None:
    payload = wire.encode_depth(np.ones((2, 2), np.float32), 5, frame="camera_optical")
    assert peek_frame(payload, "depth") == "camera_optical"
    for cut in (payload[:16], payload[:20]):
        with pytest.raises(SensorError, match=rf"^depth: {len(cut)} bytes have no frame_id$"):
            peek_frame(cut, "depth")
    for damaged in (b"", b"\x00", b"\x00\x07" + payload[2:]):
        with pytest.raises(SensorError, match="are not a stamped CDR message"):
            peek_frame(damaged, "depth")
