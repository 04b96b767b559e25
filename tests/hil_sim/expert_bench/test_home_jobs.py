"""Homes are made each by a process of its own, and what goes wrong there is told."""

import os
import signal
from pathlib import Path

import pytest

from hil_sim.expert_bench.home_jobs import make_homes
from runtime.errors import RfNavError


def die(name: str) -> None:
    signal.raise_signal(signal.SIGKILL)


def test_what_is_to_do_is_done_and_no_more(tmp_path: Path) -> None:
    names = [str(tmp_path / name) for name in "abc"]
    os.mkdir(names[0])
    make_homes(names, names[1:], 2, os.mkdir)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a", "b", "c"]


def test_a_mistake_is_told_as_it_is(tmp_path: Path) -> None:
    with pytest.raises(FileExistsError):
        make_homes([str(tmp_path)], [str(tmp_path)], 1, os.mkdir)


def test_a_worker_that_dies_is_told_of() -> None:
    with pytest.raises(RfNavError, match=r"a worker died \(out of memory\?\); run again to go on"):
        make_homes(["x"], ["x"], 1, die)
