"""What is done to a service, and who starts it again."""

import shutil
import signal
import sys
import time
from collections.abc import Callable
from pathlib import Path

import pytest

from hil_sim.driving.installed_service import (
    Child,
    Unit,
    beside,
    check_small,
    fill,
    put_aside,
    resident_mb,
)
from hil_sim.driving.link import HarnessError

SLEEPS = [sys.executable, "-c", "import time; time.sleep(600)"]


def waited(for_: Callable[[], bool], most_s: float = 20.0) -> bool:
    until_s = time.monotonic() + most_s
    while time.monotonic() < until_s:
        if for_():
            return True
        time.sleep(0.02)
    return False


def test_a_child_that_is_killed_is_started_again(tmp_path: Path):
    child = Child(SLEEPS, tmp_path / "log")
    assert child.starts() == 1
    assert waited(lambda: (child.memory_mb() or 0.0) > 0.1)
    beside(child, "kill", 0.0)
    assert waited(lambda: child.starts() == 2)
    beside(child, "restart", 0.0)
    assert waited(lambda: child.starts() == 3)
    child.close()
    child.close()
    assert {path.name for path in tmp_path.iterdir()} == {"log-1", "log-2", "log-3"}
    assert not child.memory_mb()


def test_a_frozen_child_goes_on(tmp_path: Path):
    child = Child(SLEEPS, tmp_path / "log")
    beside(child, "freeze", 0.05)
    pid = child._process.pid
    state = Path(f"/proc/{pid}/stat")
    assert waited(lambda: state.read_text().rpartition(")")[2].split()[0] != "T")
    assert child.starts() == 1
    child.close()


class Small:
    total = 1 << 20


class Signals:
    """A service with a disk of its own."""

    def __init__(self, full_disk: Path) -> None:
        self.full_disk = full_disk


def test_a_full_disk_is_emptied_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(shutil, "disk_usage", lambda path: Small)
    (tmp_path / "filler").symlink_to("/dev/full")  # nothing can be written there: it ends at once
    beside(Signals(tmp_path), "disk-full", 0.0)  # type: ignore[arg-type]
    assert not list(tmp_path.iterdir())


def test_a_disk_that_others_live_on_is_not_filled(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    class Large:
        total = 1 << 40

    monkeypatch.setattr(shutil, "disk_usage", lambda path: Large)
    with pytest.raises(HarnessError, match="large disk"):
        check_small(tmp_path)
    with pytest.raises(HarnessError, match="large disk"):
        fill(tmp_path)


def test_a_unit_is_told_by_systemctl_within_its_container(tmp_path: Path):
    """`within` is a script that writes down what it is asked, and answers as systemd does."""
    script, asked = tmp_path / "within", tmp_path / "asked"
    script.write_text(
        f'#!/bin/sh\necho "$@" >> {asked}\ncase "$*" in *MainPID*) echo 7;; '
        f"*InvocationID*) echo $(wc -l <{asked});; "
        '*/proc/7/status) printf "Name:\\tx\\nVmRSS:\\t   2048 kB\\n";; *missing*) exit 5;; esac\n'
    )
    script.chmod(0o700)
    unit = Unit("rf-nav.service", [str(script)])
    unit.restart()
    unit.signal(signal.SIGKILL)
    assert unit.memory_mb() == 2.0
    assert [unit.starts(), unit.starts()] == [1, 2]
    first, second, *_ = asked.read_text().splitlines()
    assert first == "systemctl restart --no-block rf-nav.service"
    assert second == "systemctl kill --kill-whom=main --signal=9 rf-nav.service"


def test_a_unit_that_is_not_there_is_told_in_one_line(tmp_path: Path):
    with pytest.raises(HarnessError, match="is-no-program"):
        Unit("rf-nav.service", [str(tmp_path / "is-no-program")]).restart()
    with pytest.raises(HarnessError, match="systemctl restart"):
        Unit("rf-nav.service", ["/bin/false"]).restart()


def test_memory_is_read_where_there_is_any():
    assert resident_mb("VmPeak:\t 9 kB\nVmRSS:\t1024 kB\n") == 1.0
    assert resident_mb("Name:\tzombie\n") is None


def test_what_could_not_be_read_is_counted(tmp_path: Path):
    (tmp_path / "rf-nav").mkdir()
    (tmp_path / "rf-nav" / "zones.json").touch()
    assert put_aside(tmp_path) == 0
    (tmp_path / "rf-nav" / "zones.json.aside-1").touch()
    assert put_aside(tmp_path) == 1
