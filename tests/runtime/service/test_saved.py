"""Old or new, never half; and what cannot be read is never lost."""

from pathlib import Path

import pytest
from cut_disk import CutDisk, PowerCutError

from runtime.errors import SavedError
from runtime.service.saved import ASIDE, Disk, save, saved

OLD, NEW = b"what was there before", b"what is there now, and longer"
STEPS = 4  # write, sync, replace, sync the folder


def read(raw: bytes) -> bytes:
    if raw not in (OLD, NEW):
        raise ValueError("neither")
    return raw


@pytest.mark.parametrize("before", [OLD, None])
@pytest.mark.parametrize("renamed", [False, True])
@pytest.mark.parametrize("steps", range(STEPS))
def test_a_power_cut_at_any_step_leaves_the_old_or_the_new(
    tmp_path: Path, steps: int, renamed: bool, before: bytes | None
):
    path, disk = tmp_path / "state" / "file", CutDisk(steps)
    if before is not None:
        save(path, before)
    with pytest.raises(PowerCutError):
        save(path, NEW, disk)
    disk.cut(renamed)
    assert saved(path, read, 100) in (before, NEW)
    save(path, NEW)  # what was left behind is in nobody's way
    assert saved(path, read, 100) == NEW
    assert [p.name for p in path.parent.iterdir()] == ["file"]


@pytest.mark.parametrize("renamed", [False, True])
def test_what_was_saved_is_new_after_a_power_cut(tmp_path: Path, renamed: bool):
    path, disk = tmp_path / "file", CutDisk(STEPS)
    save(path, OLD)
    save(path, NEW, disk)
    disk.cut(renamed)
    assert saved(path, read, 100) == NEW


class Unsynced(CutDisk):
    def sync(self, path: Path) -> None:
        self._step()


def test_the_double_would_show_a_write_that_is_not_synced(tmp_path: Path):
    path, disk = tmp_path / "file", Unsynced(STEPS)
    save(path, OLD)
    save(path, NEW, disk)
    disk.cut(renamed=True)
    with pytest.raises(SavedError):
        saved(path, read, 100)


@pytest.mark.parametrize("steps", range(STEPS - 1))
def test_on_a_full_disk_the_file_is_the_one_before(tmp_path: Path, steps: int):
    path = tmp_path / "file"
    save(path, OLD)
    with pytest.raises(SavedError, match=r"file: cannot be written \(No space left"):
        save(path, NEW, CutDisk(steps, full=True))
    assert saved(path, read, 100) == OLD
    assert [p.name for p in tmp_path.iterdir()] == ["file"]


def test_where_nothing_may_be_written_it_says_so(tmp_path: Path):
    (tmp_path / "file").write_bytes(b"")
    with pytest.raises(SavedError, match=r"let rfnav write there"):
        save(tmp_path / "file" / "below", NEW)


def test_what_cannot_be_read_is_kept_aside_each_under_a_name_of_its_own(tmp_path: Path):
    path = tmp_path / "file"
    for number in (1, 2):
        path.write_bytes(b"spoilt %d" % number)
        with pytest.raises(SavedError, match=f"neither; it was put aside as file.aside-{number}"):
            saved(path, read, 100)
        assert not path.exists()
        assert (tmp_path / f"file.aside-{number}").read_bytes() == b"spoilt %d" % number
    assert saved(path, read, 100) is None


def test_the_last_name_aside_is_used_again(tmp_path: Path):
    for number in range(1, ASIDE + 1):
        (tmp_path / f"file.aside-{number}").touch()
    (tmp_path / "file").write_bytes(b"spoilt")
    with pytest.raises(SavedError, match=f"aside-{ASIDE}"):
        saved(tmp_path / "file", read, 100)


def test_a_file_that_is_too_long_is_no_file_of_ours(tmp_path: Path):
    path = tmp_path / "file"
    save(path, NEW)
    with pytest.raises(SavedError, match=r"more than 28 bytes"):
        saved(path, read, len(NEW) - 1)


def test_what_cannot_be_opened_stays_where_it_is(tmp_path: Path):
    path = tmp_path / "file"
    path.mkdir()
    with pytest.raises(SavedError, match=r"cannot be read"):
        saved(path, read, 100)
    assert path.is_dir()


def test_what_cannot_be_put_aside_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    def refuses(self: Disk, path: Path) -> None:
        raise OSError(30, "Read-only file system")

    (tmp_path / "file").write_bytes(b"spoilt")
    monkeypatch.setattr(Disk, "sync", refuses)
    with pytest.raises(SavedError, match=r"cannot be put aside \(Read-only file system\)"):
        saved(tmp_path / "file", read, 100)
