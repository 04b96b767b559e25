"""A drive is written as it is told, in the order of telling; what cannot be is counted."""

import errno
import json
import threading
import time
import weakref
from dataclasses import replace
from pathlib import Path
from types import FrameType

import cv2
import numpy as np
import pytest
from camera_messages import compressed_depth, compressed_image, png
from sighted import sight

from runtime.core.geometry import GridFrame
from runtime.core.types import Brief, Detections, FrontierBrief, Intrinsics, Observation, Pose
from runtime.recording import drive_files, exact
from runtime.recording import recorder as recording
from runtime.recording.drive_files import WholeDrive
from runtime.recording.messages import Encoder
from runtime.recording.pictures import Picture
from runtime.recording.reader import messages
from runtime.recording.recorder import Recorder, held_bytes
from runtime.robot import wire
from runtime.robot.images.reading import decode_color, decode_depth
from runtime.robot.session import BusConfig, TopicsConfig
from runtime.robot.streams import ConsumedFrame, WireMessage
from runtime.robot.sync import Match, RawMessage
from runtime.robot.transforms import CameraConfig, peek_frame

DEPTH, COLOR = "/camera/depth/image_raw", "/camera/color/image_raw/compressed"
FIRST = "configuration", {"values": {}, "lockstep": False}


def begun(tmp_path: Path, colour: bool = True, bus: BusConfig | None = None) -> Recorder:
    encoder = Encoder(bus or BusConfig(), CameraConfig(), colour)
    return Recorder(WholeDrive(tmp_path, {}), encoder, FIRST)


def frame(depth_m: np.ndarray, encoding: str = "32FC1") -> ConsumedFrame:
    height, width = depth_m.shape
    rgb = np.zeros((height, width, 3), np.uint8)
    rgb[:, width // 2 :] = 200, 40, 10
    color = RawMessage(7, wire.encode_color(rgb, 7, "lens"), 0.5)
    depth = RawMessage(8, wire.encode_depth(depth_m, 8, "lens", encoding), 0.6)
    odometry = RawMessage(8, b"", 0.4)
    decoded = decode_depth(depth.payload, "depth").value
    pose, lens = Pose(1 / 3, 0.2, 0.1), Intrinsics(50.0, 50.0, width / 2, height / 2, width, height)
    match = Match(color, depth, odometry, odometry)
    return ConsumedFrame(match, Observation(8, rgb, decoded, pose, lens), 0.7)


def read(tmp_path: Path) -> dict[str, list]:
    found: dict[str, list] = {}
    for message in messages(next(tmp_path.iterdir())):
        found.setdefault(message.topic, []).append(message)
    return found


def test_everything_is_written_in_the_order_of_telling(tmp_path: Path):
    recorder = begun(tmp_path)
    for n in range(200):
        recorder("heard", {"name": "asked_mps", "value": n / 7})
    summary = recorder.close()
    found = list(messages(summary.paths[0]))
    assert [m.topic for m in found] == ["/loop/configuration", *["/loop/heard"] * 200]
    assert [json.loads(m.payload)["value"] for m in found[1:]] == [n / 7 for n in range(200)]
    assert summary.dropped == {}
    assert "MB a minute" in summary.in_words()


@pytest.mark.parametrize("whole_mm", [True, False])
def test_depth_is_without_loss_and_small_where_it_can_be(tmp_path: Path, whole_mm: bool):
    depth_m = np.random.default_rng(1).uniform(0.3, 9.0, (24, 32)).astype(np.float32)
    depth_m[3, :5] = 0.0, np.nan, np.inf, -1.0, 65.534
    if whole_mm:
        depth_m = np.round(depth_m * 1000).astype(np.float32) / 1000
    recorder, told = begun(tmp_path), frame(depth_m)
    recorder("frame", told)
    recorder.close()
    (image,) = read(tmp_path)[DEPTH]
    assert np.array_equal(decode_depth(image.payload, "d").value, told.observation.depth_m)
    assert (len(image.payload) < 3 * depth_m.size) == whole_mm


def test_a_frame_has_its_images_before_it(tmp_path: Path):
    recorder, told = begun(tmp_path), frame(np.ones((24, 32), np.float32), "16UC1")
    recorder("frame", told)
    recorder.close()
    topics = [m.topic for m in messages(next(tmp_path.iterdir()))]
    assert topics == ["/loop/configuration", "/loop/tf", COLOR, DEPTH, "/loop/frame"]
    found = read(tmp_path)
    about = json.loads(found["/loop/frame"][0].payload)
    assert about["pose"] == {"x_m": 1 / 3, "y_m": 0.2, "yaw_rad": 0.1}
    assert (about["stamp_ns"], about["color_stamp_ns"], about["now_s"]) == (8, 7, 0.7)
    rgb = decode_color(found[COLOR][0].payload, COLOR, packed=True).value
    assert np.abs(rgb.astype(int) - told.observation.rgb).mean() < 8
    base, camera = wire.decode_transforms(found["/loop/tf"][0].payload, "tf")
    assert (base.parent, base.child, camera.parent, camera.child) == (
        "odom", "base_link", "base_link", "lens",
    )  # fmt: skip
    assert camera.quaternion == pytest.approx([-0.5, 0.5, -0.5, 0.5])  # REP 103, a level camera


def test_a_frame_tells_whether_its_images_are_as_they_came(tmp_path: Path):
    recorder, told = begun(tmp_path), frame(np.ones((24, 32), np.float32))
    for one in (told, replace(told, altered=True)):
        recorder("frame", one)
    recorder.close()
    told_of = read(tmp_path)["/loop/frame"]
    assert [json.loads(m.payload)["altered"] for m in told_of] == [False, True]


def test_colour_of_a_frame_without_a_name_ends_no_recording(tmp_path: Path):
    recorder, told = begun(tmp_path), frame(np.ones((24, 32), np.float32))
    nameless = RawMessage(7, wire.encode_color(told.observation.rgb, 7, "\n"), 0.5)
    recorder("frame", replace(told, match=replace(told.match, color=nameless)))
    assert recorder.close().error == ""
    assert peek_frame(read(tmp_path)[COLOR][0].payload, COLOR) == "lens"


def test_colour_that_came_compressed_is_kept_as_it_came(tmp_path: Path):
    bus = BusConfig(topics=TopicsConfig(color="cam/compressed"))
    recorder, told = begun(tmp_path, bus=bus), frame(np.ones((24, 32), np.float32))
    jpeg = cv2.imencode(".jpg", told.observation.rgb)[1].tobytes()
    object.__setattr__(told.match, "color", RawMessage(7, jpeg, 0.5))
    recorder("frame", told)
    recorder.close()
    assert [m.payload for m in read(tmp_path)["/cam/compressed"]] == [jpeg]


def test_depth_is_recorded_as_it_was_used_whatever_it_came_as(tmp_path: Path):
    topics = TopicsConfig(depth="cam/depth/compressedDepth")
    recorder, told = begun(tmp_path, bus=BusConfig(topics=topics)), frame(np.ones((24, 32)))
    tenths = compressed_image(*compressed_depth(png(np.full((24, 32), 10_000, np.uint16))), 8)
    object.__setattr__(told.match, "depth", RawMessage(8, tenths, 0.6))
    recorder("frame", told)
    recorder.close()
    (image,) = read(tmp_path)["/cam/depth"]
    assert peek_frame(image.payload, "d") == "camera"
    assert np.array_equal(decode_depth(image.payload, "d").value, told.observation.depth_m)


def test_images_that_were_set_right_are_recorded_as_they_were_used(tmp_path: Path):
    bus = BusConfig(topics=TopicsConfig(color="cam/compressed"))
    recorder, told = begun(tmp_path, bus=bus), frame(np.ones((24, 32), np.float32), "16UC1")
    upright = np.full((32, 24), 1 / 3, np.float32)
    seen = replace(told.observation, depth_m=upright, rgb=np.full((32, 24, 3), 90, np.uint8))
    recorder("frame", replace(told, observation=seen, altered=True))
    recorder.close()
    found = read(tmp_path)
    image = decode_depth(found[DEPTH][0].payload, "depth")
    assert np.array_equal(image.value, upright)
    assert image.stamp_ns == 8
    rgb = decode_color(found["/cam/compressed"][0].payload, "colour", packed=True).value
    assert rgb.shape == (32, 24, 3)


def test_damaged_odometry_is_kept_and_ends_nothing(tmp_path: Path):
    recorder, whole = begun(tmp_path), wire.encode_odometry(Pose(1.0, 0.0, 0.0), 9, "floor")
    for payload in (whole, whole[:13]):  # a stamp, and no frame_id
        recorder("wire", WireMessage("odom", wire.ODOMETRY, payload))
    recorder("frame", frame(np.ones((24, 32), np.float32)))
    recorder.close()
    found = read(tmp_path)
    assert [m.payload for m in found["/odom"]] == [whole, whole[:13]]
    base, _ = wire.decode_transforms(found["/loop/tf"][0].payload, "tf")
    assert base.parent == "floor"


def test_with_privacy_there_is_no_colour(tmp_path: Path):
    recorder = begun(tmp_path, colour=False)
    recorder("frame", frame(np.ones((24, 32), np.float32)))
    recorder.close()
    found = read(tmp_path)
    assert COLOR not in found
    assert DEPTH in found


def test_what_does_not_fit_is_counted_and_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(recording, "BACKLOG_BYTES", 20_000)
    writing, go_on = threading.Event(), threading.Event()
    drafts = Encoder.drafts

    def slow(self: Encoder, kind: str, value: object):
        writing.set()
        assert go_on.wait(20.0)
        return drafts(self, kind, value)

    monkeypatch.setattr(Encoder, "drafts", slow)
    recorder = begun(tmp_path)
    recorder("rest", {"state": "ready"})
    assert writing.wait(20.0)
    for _ in range(30):
        recorder("heard", {"name": "likeness", "value": np.zeros(250, np.float32)})
    recorder("wire", WireMessage("odom", wire.ODOMETRY, bytes(30_000)))
    for kind in ("rest", "halt", "tick") * 10:  # what is small, and says why the base stood still
        recorder(kind, {"kind": "", "driving": False})
    recorder("fault", "the disk is slow")
    go_on.set()
    summary = recorder.close()
    lost = summary.dropped["heard"]
    assert lost == 30 - (20_000 - 1000) // 2000
    assert summary.dropped == {"heard": lost, "wire": 1}
    assert f"lost: {lost} heard, 1 wire" in summary.in_words()
    found = read(tmp_path)
    (told,) = found["/loop/recorder"]
    assert json.loads(told.payload)["dropped"] == {"heard": lost, "wire": 1}
    counts = {topic: len(found[f"/loop/{topic}"]) for topic in ("heard", "rest", "halt", "tick")}
    assert counts == {"heard": 30 - lost, "rest": 11, "halt": 11, "tick": 10}


def test_what_is_held_is_counted():
    told = frame(np.ones((48, 64), np.float32))
    assert 14 < held_bytes(told) / (48 * 64) < 15  # depth of 4 and colour of 3, twice
    none, few = np.zeros(0, np.int32), np.zeros((10, 512), np.float32)
    seen = Detections(np.zeros((10, 4), np.float32), np.zeros(10, np.float32), none, few, few[0])
    assert 22_000 < held_bytes(seen) < 25_000
    asked = tuple(FrontierBrief(n, 1.0, (), (), few[n], b"an image" * 1000) for n in range(3))
    assert 30_000 < held_bytes({"why": "", "brief": Brief("toilet", 0, asked)}) < 33_000
    toward = replace(
        asked[0], sight=replace(sight(0.5), features=np.zeros((50, 10, 10), np.float16))
    )
    assert 10_000 < held_bytes({"brief": Brief("toilet", 0, (toward,))}) - 10_000 < 13_000
    mask, grid = np.zeros((100, 100), bool), GridFrame(0.0, 0.0, 0.05, 100, 100)
    assert held_bytes(Picture(0, grid, mask, mask, np.zeros((0, 2)), ())) > 20_000


@pytest.mark.parametrize("colour", [True, False])
def test_what_a_detector_saw_of_the_image_is_written_small_or_not_at_all(
    tmp_path: Path, colour: bool
):
    """Where nobody is to see a home in it, no part of an image is written, nor a view of it."""
    none, parts = np.zeros(0, np.float32), np.full((40, 2, 2), 1e9, np.float32)
    seen = Detections(np.zeros((0, 4), np.float32), none, np.zeros(0, np.int32), none, none,
                      features=parts)  # fmt: skip
    recorder, shown = begun(tmp_path, colour), FrontierBrief(1, 1.0, (), (), sight=sight(0.5))
    recorder("detections", seen)
    recorder("question", {"why": "", "brief": Brief("toilet", 0, (shown,))})
    recorder.close()
    found = read(tmp_path)
    told = json.loads(found["/loop/detections"][0].payload)
    features = exact.read(told, Detections).features
    assert features.dtype == np.float16
    assert features.shape == ((40, 2, 2) if colour else (0, 0, 0))
    assert np.isfinite(features).all()
    (question,) = json.loads(found["/loop/question"][0].payload)["brief"]["frontiers"]
    assert "sight" not in question


def test_after_the_end_nothing_is_kept_in_memory(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    writing, go_on = threading.Event(), threading.Event()

    def full(*_: object) -> None:
        writing.set()
        assert go_on.wait(20.0)
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr("runtime.recording.mcap_file.McapFile.write", full)
    recorder = begun(tmp_path)
    recorder("rest", {"state": "ready"})
    assert writing.wait(20.0)
    waiting = np.zeros(1000)
    told = weakref.ref(waiting)
    recorder("heard", {"name": "likeness", "value": waiting})
    del waiting
    assert told() is not None
    go_on.set()
    recorder._thread.join(20.0)
    assert told() is None
    late = np.zeros(1000)
    told = weakref.ref(late)
    recorder("heard", {"name": "likeness", "value": late})
    del late
    assert told() is None
    assert recorder.close().dropped == {}


def test_who_tells_waits_for_nobody(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    """Wherever the writing thread stands still, a call returns."""
    stood: set[int] = set()
    blocked: list[int] = []
    there = threading.Event()

    def stand_still(frame: FrameType, event: str, _: object):
        if frame.f_code.co_filename != recording.__file__:
            return None
        line = frame.f_lineno
        if event == "line" and line not in stood and not blocked:
            stood.add(line)
            assert there.wait(20.0)
            teller = threading.Thread(target=recorder, args=("tick", {"sent": None}))
            teller.start()
            teller.join(5.0)
            if teller.is_alive():
                blocked.append(line)
        return stand_still

    monkeypatch.setattr(recording, "FLUSH_S", 0.01)
    before = threading.gettrace()
    threading.settrace(stand_still)  # of threads that are begun from now on
    recorder = begun(tmp_path)
    threading.settrace(before)
    there.set()
    recorder("tick", {"sent": None})
    recorder("heard", {"name": "likeness", "value": np.zeros(100)})
    recorder.close()
    assert not blocked
    assert len(stood) > 20


def test_a_full_disk_ends_the_recording_and_not_the_drive(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture
):
    def full(*_: object) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr("runtime.recording.mcap_file.McapFile.write", full)
    recorder = begun(tmp_path)
    recorder("rest", {"state": "ready"})
    recorder._thread.join(20.0)
    recorder("rest", {"state": "ready"})
    summary = recorder.close()
    assert "it ended early: No space left on device" in summary.in_words()
    assert "the recording ends: No space left" in capsys.readouterr().err


def test_a_disk_that_is_full_when_a_ring_goes_on_is_no_mistake_of_ours(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture
):
    monkeypatch.setattr(drive_files, "SHORTEST_S", 0.0)
    ring = drive_files.Ring(tmp_path / "ring", 1e-4, {})
    recorder = Recorder(ring, Encoder(BusConfig(), CameraConfig(), True), FIRST)

    def full(*_: object) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(Path, "open", full)
    while recorder._thread.is_alive():
        recorder("rest", {"state": "ready"})
        time.sleep(0.01)
    told = "000002.mcap: cannot be written (No space left on device)"
    assert told in recorder.close().error
    assert told in capsys.readouterr().err


def test_a_mistake_of_ours_is_raised_at_the_end(tmp_path: Path):
    recorder = begun(tmp_path)
    recorder("rest", {"state": object()})
    with pytest.raises(TypeError, match="not recorded"):
        recorder.close()


def test_only_a_halt_on_the_road_is_a_fault(tmp_path: Path):
    class Files(WholeDrive):
        faults = 0

        def fault(self, now_s: float) -> None:
            self.faults += 1

    files = Files(tmp_path, {})
    recorder = Recorder(files, Encoder(BusConfig(), CameraConfig(), True), FIRST)
    for kind, driving in (("odometry", False), ("", True), ("frame", True)):
        recorder("halt", {"kind": kind, "reason": "", "driving": driving})
    recorder("fault", "the runtime fell over")
    recorder.close()
    assert files.faults == 2
    reasons = [json.loads(m.payload)["reason"] for m in read(tmp_path)["/loop/halt"]]
    assert reasons[-1] == "the runtime fell over"
