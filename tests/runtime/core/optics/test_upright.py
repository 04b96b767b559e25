"""A camera on its side: where each pixel and the camera itself are afterwards."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from runtime.core.geometry import optical_rays, optical_to_base
from runtime.core.optics.upright import (
    quarters_of,
    upright_axes,
    upright_image,
    upright_intrinsics,
    upright_mount,
)
from runtime.core.types import Intrinsics, Mount

CAMERA = Intrinsics(20.0, 22.0, 9.0, 5.0, 16, 12)
MOUNTS = st.builds(
    Mount,
    st.floats(-1, 1), st.floats(-1, 1), st.floats(0.1, 2),
    st.floats(-math.pi, math.pi), st.floats(-1.2, 1.2), st.floats(-3, 3),
)  # fmt: skip


@pytest.mark.parametrize(
    ("roll_deg", "quarters"),
    [(0, 0), (44, 0), (46, 1), (90, 1), (180, 2), (-180, 2), (-90, 3), (-44, 0), (270, 3)],
)
def test_the_nearest_quarter_counts(roll_deg: float, quarters: int):
    assert quarters_of(math.radians(roll_deg)) == quarters


@pytest.mark.parametrize("turned", range(4))
def test_what_is_up_in_the_room_is_up_in_the_image(turned: int):
    mount = Mount(roll_rad=turned * math.pi / 2)
    height = (optical_rays(CAMERA, 1) @ optical_to_base(mount).T)[..., 2].astype(np.float32)
    upright = upright_image(height, quarters_of(mount.roll_rad))
    assert upright.flags.c_contiguous
    assert (np.diff(upright, axis=0) < 0).all()  # from top to bottom
    left = (optical_rays(CAMERA, 1) @ optical_to_base(mount).T)[..., 1].astype(np.float32)
    assert (np.diff(upright_image(left, turned), axis=1) < 0).all()


@given(MOUNTS)
def test_each_pixel_looks_where_it_looked(mount: Mount):
    quarters = quarters_of(mount.roll_rad)
    before = optical_rays(CAMERA, 1) @ optical_to_base(mount).T
    after = (
        optical_rays(upright_intrinsics(CAMERA, quarters), 1)
        @ optical_to_base(upright_mount(mount)).T
    )
    for axis in range(3):
        turned = upright_image(before[..., axis].astype(np.float32), quarters)
        np.testing.assert_allclose(turned, after[..., axis], atol=1e-5)


@given(MOUNTS)
def test_axes_lead_from_the_camera_to_its_upright_image(mount: Mount):
    axes = upright_axes(quarters_of(mount.roll_rad))
    np.testing.assert_allclose(
        optical_to_base(upright_mount(mount)) @ axes, optical_to_base(mount), atol=1e-9
    )


def test_an_upright_camera_is_left_alone():
    mount, image = Mount(roll_rad=0.1), np.zeros((4, 5, 3), np.uint8)
    assert upright_mount(mount) is mount
    assert upright_image(image, 0) is image
    assert upright_intrinsics(CAMERA, 0) is CAMERA
