"""What is asked of the system: granted, or told in a line."""

import ctypes
import gc
import os
import subprocess
import sys
import threading
from collections.abc import Iterator

import pytest
from manual_clock import ManualClock

from runtime.loops import process
from runtime.loops.process import COLLECT_S, Garbage


def test_a_thread_that_may_not_go_first_is_told_of_in_a_line(monkeypatch: pytest.MonkeyPatch):
    def refused(*_: object) -> None:
        raise PermissionError(1, "Operation not permitted")

    monkeypatch.setattr(os, "sched_setscheduler", refused)
    said = process.go_first()
    assert said == "control: no SCHED_FIFO (Operation not permitted): it runs as other threads do"


def test_a_thread_that_may_goes_first_alone(capsys: pytest.CaptureFixture[str]):
    policies: list[int] = []

    def run() -> None:
        process.go_first_or_tell()
        policies.append(os.sched_getscheduler(threading.get_native_id()))

    thread = threading.Thread(target=run)
    thread.start()
    thread.join()
    refused = capsys.readouterr().err.startswith("rfnav: control: no SCHED_FIFO")
    assert policies == [os.SCHED_OTHER if refused else os.SCHED_FIFO]
    assert os.sched_getscheduler(0) == os.SCHED_OTHER


def test_memory_that_may_not_be_locked_whole_is_not_locked_at_all(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr("resource.getrlimit", lambda _: (8 << 20, 8 << 20))
    monkeypatch.setattr(process, "_may_lock_all", lambda: False)
    monkeypatch.setattr("ctypes.CDLL", lambda *_, **__: pytest.fail("it was locked"))
    assert process.lock_memory().startswith("memory: not locked (RLIMIT_MEMLOCK is limited)")


def test_a_sealed_process_leaves_no_core_and_is_not_looked_into() -> None:
    """In a process of its own, which cannot be undone."""
    code = (
        "import ctypes, resource; from runtime.loops.process import seal; "
        "get = ctypes.CDLL(None).prctl; before = get(3, 0, 0, 0, 0); seal(); "
        "print(before, get(3, 0, 0, 0, 0), resource.getrlimit(resource.RLIMIT_CORE))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "1 0 (0, 0)\n"
    assert done.stderr == ""


class Node:
    me: "Node"


def cycle() -> Node:
    node = Node()
    node.me = node
    return node


def nodes() -> int:
    return sum(isinstance(o, Node) for o in gc.get_objects())


@pytest.fixture
def collecting() -> Iterator[tuple[ManualClock, Garbage]]:
    clock = ManualClock()
    garbage = Garbage(clock)
    garbage.begin()
    yield clock, garbage
    gc.enable()
    gc.unfreeze()


def test_garbage_is_collected_every_few_seconds_and_what_was_loaded_never(
    collecting: tuple[ManualClock, Garbage],
):
    clock, garbage = collecting
    assert not gc.isenabled()
    assert gc.get_freeze_count() > 0
    cycle()
    assert not garbage.due()
    clock.advance(COLLECT_S)
    assert garbage.due()
    assert nodes() == 1
    garbage.collect()
    assert not garbage.due()
    assert nodes() == 0


def test_on_the_road_only_what_is_new_is_looked_at_and_all_of_it_after(
    collecting: tuple[ManualClock, Garbage],
):
    _, garbage = collecting
    old = cycle()
    garbage.collect()
    del old  # it has lived through a collection
    garbage.collect()
    assert nodes() == 1
    garbage.collect_all()
    assert nodes() == 0


MAPPED = """
import ctypes, sys
from runtime.loops.process import keep_little

class Told(ctypes.Structure):  # glibc's mallinfo2
    _fields_ = [(name, ctypes.c_size_t) for name in "abc"] + [("mapped", ctypes.c_size_t)]
    _fields_ += [(name, ctypes.c_size_t) for name in "defghi"]

libc = ctypes.CDLL(None)
libc.mallinfo2.restype = Told
if sys.argv[1] == "little":
    keep_little()
block = bytearray(24 << 20)
del block  # from now on malloc takes such sizes from its own, unless it was told
before = libc.mallinfo2().mapped
blocks = [bytearray(12 << 20) for _ in range(3)]
print(libc.mallinfo2().mapped - before)
"""


@pytest.mark.skipif(not hasattr(ctypes.CDLL(None), "mallinfo2"), reason="malloc is not glibc's")
@pytest.mark.parametrize(("how", "mapped"), [("little", 3), ("as it is", 0)])
def test_large_blocks_are_the_systems_own_whatever_came_before(how: str, mapped: int):
    command = [sys.executable, "-c", MAPPED, how]
    said = subprocess.run(command, capture_output=True, check=True, text=True).stdout
    assert int(said) == mapped


def test_the_end_is_known_while_the_main_thread_is_busy_elsewhere():
    """In a process of its own, for handlers of signals are the whole process's."""
    script = """
import hashlib, os, signal, threading
from runtime.loops.process import EndSignal
end, known, over = EndSignal(), [], []
def ask():
    known.append(end())
    os.kill(os.getpid(), signal.SIGTERM)
    while not end():
        pass
    known.append(not over)
asking = threading.Thread(target=ask)
asking.start()
hashlib.pbkdf2_hmac("sha256", b"", b"", 8_000_000)  # in C, which lets others run
over.append(True)
asking.join()
assert known == [False, True], known
assert end()
"""
    done = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, timeout=300
    )
    assert done.returncode == 0, done.stderr
