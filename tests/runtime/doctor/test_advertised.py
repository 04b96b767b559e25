"""Liveliness tokens as the bridge and rmw_zenoh declare them, written down from their sources."""

import pytest

from runtime.doctor.advertised import Advertised, instead, prefix_of, read_token

IMAGE, INFO = "sensor_msgs/msg/Image", "sensor_msgs/msg/CameraInfo"
ZID = "aac3178e146ba6f1fc6e6a4085e77f21"


@pytest.mark.parametrize(
    ("key", "told"),
    [
        (
            f"@/{ZID}/@ros2_lv/MP/oak§rgb§image_raw/sensor_msgs§msg§Image/:::5,10",
            Advertised("oak/rgb/image_raw", IMAGE, "ros2dds"),
        ),
        (
            f"@ros2_lv/2/{ZID}/0/10/MP/%/%/talker/%camera%color%image_raw/"
            "sensor_msgs::msg::dds_::Image_/RIHS01_d31d41a9a4c4bc8eae9be757b0beed306564f7526c88ea6a4588fb9582527d47/"
            "::,7:,:,:,,",
            Advertised("camera/color/image_raw", IMAGE, "rmw_zenoh", domain=2),
        ),
        (
            f"@/{ZID}/@ros2_lv/MS/cmd_vel/geometry_msgs§msg§TwistStamped/:::",
            Advertised("cmd_vel", "geometry_msgs/msg/TwistStamped", "ros2dds", publishes=False),
        ),
        (
            f"@ros2_lv/0/{ZID}/0/10/MS/%/%/base/%cmd_vel/geometry_msgs::msg::dds_::Twist_/"
            "TypeHashNotSupported/::,1:,:,:,,",
            Advertised(
                "cmd_vel", "geometry_msgs/msg/Twist", "rmw_zenoh", publishes=False, hashed=False
            ),
        ),
        (f"@ros2_lv/x/{ZID}/0/10/MP/%/%/base/%odom/nav_msgs::msg::dds_::Odometry_/h/q", None),
        (f"@/{ZID}/@ros2_lv/SS/srv/std_srvs§srv§Empty/:::", None),
        (f"@ros2_lv/2/{ZID}/0/0/NN/%/%/talker", None),
        (f"@/{ZID}/@ros2_lv", None),
        ('@/z/@ros2_lv/MP/a"b/sensor_msgs§msg§Image/:::', None),
        ("@/z/@ros2_lv/MP/a\x1b[2J/sensor_msgs§msg§Image/:::", None),
        ("", None),
    ],
)
def test_publishers_are_read_and_nothing_else(key: str, told: Advertised | None):
    assert read_token(key) == told


def there(*told: tuple[str, str]) -> list[Advertised]:
    return [Advertised(topic, kind, "ros2dds") for topic, kind in told]


OAK = there(
    ("oak/rgb/image_raw", IMAGE), ("oak/stereo/image_raw", IMAGE), ("oak/left/image_rect", IMAGE),
    ("oak/rgb/camera_info", INFO), ("oak/stereo/camera_info", INFO),
)  # fmt: skip


def test_what_could_be_meant_is_of_the_type_and_named_like_it():
    color = instead("color", "camera/color/image_raw", {IMAGE}, OAK, ())
    assert color[0] == "oak/rgb/image_raw"
    assert "oak/stereo/image_raw" not in color
    assert instead("depth", "camera/depth/image_raw", {IMAGE}, OAK, ()) == ["oak/stereo/image_raw"]
    info = instead("camera_info", "camera/color/camera_info", {INFO}, OAK, ())
    assert info == ["oak/rgb/camera_info"]
    assert instead("odom", "odom", {"nav_msgs/msg/Odometry"}, OAK, ()) == []


def test_what_is_used_already_is_not_offered():
    assert instead("depth", "d", {IMAGE}, OAK, ("/oak/stereo/image_raw",)) == []


def test_a_namespace_is_found_where_all_are_in_it():
    robot = there(("r1/odom", "x"), ("r1/camera/color/image_raw", IMAGE), ("other/odom", "x"))
    assert prefix_of(["odom", "camera/color/image_raw"], robot) == "r1"
    assert prefix_of(["odom", "camera/depth/image_raw"], robot) == ""
    assert prefix_of([], robot) == ""
