"""What `rfnav run` is told about recording."""

from pathlib import Path

import pytest

from runtime.commands.record import RecordOptions, recording
from runtime.config import load
from runtime.errors import BusError, ConfigError
from runtime.record import unrecorded
from runtime.recording.reader import Recording, messages


def test_without_a_directory_nothing_is_recorded():
    with recording(load(None), RecordOptions(None, 0.0, False), False) as record:
        assert record is unrecorded


def test_a_ring_needs_a_place():
    with (
        pytest.raises(ConfigError, match=r"--record-last: goes with --record DIR"),
        recording(load(None), RecordOptions(None, 5.0, False), False),
    ):
        pass


CLOUD = ("cloud.enabled=true", "cloud.base_url=http://127.0.0.1:1/v1", "cloud.model=m",
         "cloud.price_in_usd=1.0", "cloud.price_out_usd=1.0")  # fmt: skip


@pytest.mark.parametrize(
    ("settings", "privacy", "colour"),
    [((), False, "jpeg"), ((), True, "none"), (CLOUD, False, "none"),
     ((*CLOUD, "cloud.privacy=full", "keyframes.image_width_px=320"), False, "jpeg")],
)  # fmt: skip
def test_colour_is_written_where_privacy_allows_it(
    settings: tuple[str, ...], privacy: bool, colour: str, tmp_path: Path
):
    config = load(None, settings)
    with recording(config, RecordOptions(tmp_path, 0.0, privacy), False):
        pass
    (path,) = tmp_path.iterdir()
    assert Recording(path).about["colour"] == colour


def test_what_ends_the_runtime_is_written_and_keeps_the_ring(
    tmp_path: Path, capsys: pytest.CaptureFixture
):
    def drive() -> None:
        with recording(load(None), RecordOptions(tmp_path, 1.0, False), True) as record:
            record("rest", {"state": "ready"})
            raise BusError("the bus is gone")

    with pytest.raises(BusError):
        drive()
    (kept,) = tmp_path.iterdir()
    assert kept.name.startswith("fault-")
    assert b"the bus is gone" in list(messages(kept))[-1].payload
    said = capsys.readouterr().err
    assert "MB a minute" in said
    assert str(kept) in said


def test_what_ended_the_drive_is_told_whatever_ended_the_recording(tmp_path: Path):
    def drive() -> None:
        with recording(load(None), RecordOptions(tmp_path, 0.0, False), True) as record:
            record("rest", {"state": object()})
            raise BusError("the bus is gone")

    with pytest.raises(BusError, match="the bus is gone") as told:
        drive()
    assert "TypeError" in told.value.__notes__[0]


def test_a_recording_that_a_mistake_of_ours_ended_is_raised_after_the_drive(tmp_path: Path):
    def drive() -> None:
        with recording(load(None), RecordOptions(tmp_path, 0.0, False), True) as record:
            record("rest", {"state": object()})

    with pytest.raises(TypeError, match="not recorded"):
        drive()
