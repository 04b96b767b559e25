"""CameraInfo, as drivers send it, becomes a lens or is told of in one line."""

import pytest
from other_half import camera_info

from runtime.core.optics.lens import Lens, straightened
from runtime.core.types import Intrinsics
from runtime.errors import SensorError
from runtime.robot.calibration import decode_lens, is_rectified

SIZE, K = (640, 480), (600.0, 601.0, 321.0, 243.0)
INTRINSICS = Intrinsics(*K, *SIZE)
BENT = (-0.05, 0.01, 0.001, 0.0, 0.0)


@pytest.mark.parametrize(
    ("model", "told", "coefficients", "fisheye"),
    [
        ("plumb_bob", BENT, BENT, False),
        ("plumb_bob", BENT[:4], BENT[:4], False),
        ("rational_polynomial", (*BENT, 0.1, 0.2, 0.3), (*BENT, 0.1, 0.2, 0.3), False),
        ("rational_polynomial", (*BENT, 0.1), (*BENT, 0.1, 0.0, 0.0), False),
        ("equidistant", (0.01, -0.02, 0.0, 0.0), (0.01, -0.02, 0.0, 0.0), True),
        ("", BENT, BENT, False),
        ("plumb_bob", (0.0,) * 5, (), False),
        ("plumb_bob", (), (), False),
        ("Brown Conrady", (0.0,) * 5, (), False),  # of zeros every model makes a pinhole
    ],
)
def test_coefficients_are_as_opencv_has_them(model, told, coefficients, fisheye):
    lens = decode_lens(camera_info(SIZE, K, told, model), "info")
    assert (lens.intrinsics, lens.coefficients, lens.fisheye) == (INTRINSICS, coefficients, fisheye)


def test_rectified_images_are_those_of_p():
    payload = camera_info(SIZE, K, BENT, p=(580.0, 581.0, 320.0, 240.0))
    lens = decode_lens(payload, "info", rectified=True)
    assert (lens.intrinsics, lens.coefficients) == (Intrinsics(580, 581, 320, 240, *SIZE), ())
    without = camera_info(SIZE, K, BENT, p=(0.0, 0.0, 0.0, 0.0))
    assert decode_lens(without, "info", rectified=True).intrinsics == INTRINSICS


@pytest.mark.parametrize("rectified", [False, True])
def test_intrinsics_are_those_of_the_part_and_the_pixels_that_are_sent(rectified):
    def sent(**part):
        return decode_lens(camera_info(SIZE, K, **part), "info", rectified).intrinsics

    assert sent(binning=(1, 1), roi=(0, 0, 480, 640)) == INTRINSICS
    assert sent(binning=(2, 4)) == Intrinsics(300, 150.25, 160.5, 60.75, 320, 120)
    part = 100, 40, 400, 500
    assert sent(roi=part) == Intrinsics(600, 601, 221, 203, 500, 400)
    assert sent(binning=(2, 2), roi=part) == Intrinsics(300, 300.5, 110.5, 101.5, 250, 200)


@pytest.mark.parametrize("part", [{"binning": (2**31, 1)}, {"roi": (0, 0, 1, 640)}])
def test_a_part_that_no_image_is_of_is_told_of(part):
    with pytest.raises(SensorError, match=r"info: an image of .* must be 8 to 8192"):
        decode_lens(camera_info(SIZE, K, **part), "info")


def test_a_lens_is_read_without_what_straightens_whole_images():
    straightened.cache_clear()
    decode_lens(camera_info(SIZE, K, BENT), "info")
    with_lens = Lens(INTRINSICS, BENT)
    misses = straightened.cache_info().misses
    straightened(with_lens)
    assert straightened.cache_info().misses == misses + 1


@pytest.mark.parametrize(
    ("topic", "rectified"),
    [
        ("camera/color/image_raw", False),
        ("camera/color/image_rect_color", True),
        ("camera/color/image_rect/compressed", True),
        ("camera/depth/image_rect_raw", True),
        ("direct/image_raw", False),
        ("aligned_depth_to_color/image_raw", False),
    ],
)
def test_a_topic_s_name_says_whether_it_is_rectified(topic, rectified):
    assert is_rectified(topic) is rectified


@pytest.mark.parametrize(
    ("model", "told", "why"),
    [
        ("omnidirectional", (0.1, 0.2), "are understood"),
        ("equidistant", (0.1,) * 5, "are understood"),
        ("plumb_bob", (float("nan"), 0.0, 0.0, 0.0, 0.0), "are understood"),
        ("plumb_bob", (400.0, 0.0, 0.0, 0.0, 0.0), "of the image were seen"),
    ],
)
def test_what_is_no_lens_is_told_of_with_the_remedy(model, told, why):
    with pytest.raises(SensorError) as caught:
        decode_lens(camera_info(SIZE, K, told, model), "cam/info")
    line = str(caught.value)
    assert line.startswith(f"cam/info: distortion {model!r}")
    assert why in line
    assert "publish rectified images" in line
    assert "\n" not in line
