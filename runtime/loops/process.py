"""What the process asks of the system so that its control loop is in time: a thread that goes
before all others, memory that stays, and no garbage collection while a frame waits; and that nobody
looks into its memory. What is not granted is told in a line, and the loop goes on without."""

import ctypes
import gc
import os
import resource
import signal
import socket
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Final

from runtime.clock import Clock
from runtime.log import say

FIFO_PRIORITY = 20  # above ordinary threads, below the kernel's own
COLLECT_S = 5.0  # between collections
_CAP_IPC_LOCK: Final = 14
_M_MMAP_THRESHOLD: Final = -3
_OWN_BYTES: Final = 4 << 20  # blocks that large are the system's again as soon as they are freed
_MCL_CURRENT: Final = 1
_MCL_FUTURE: Final = 2
_MCL_ONFAULT: Final = 4  # what is touched stays; what is not takes no memory
_PR_SET_DUMPABLE: Final = 4

SWITCH_S = 0.0005  # a thread that computes lets the control loop in so soon


def seal() -> None:
    """Keys lie in memory: a crash leaves no core, neither in a file nor with a program that
    collects them, and no other process of the same user reads it."""
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    if ctypes.CDLL(None, use_errno=True).prctl(_PR_SET_DUMPABLE, 0, 0, 0, 0) != 0:
        _tell(f"memory: can be dumped ({os.strerror(ctypes.get_errno())})")


def prepare() -> None:
    """The process as a whole, before its threads begin."""
    sys.setswitchinterval(SWITCH_S)
    keep_little()
    _tell(lock_memory())


def go_first_or_tell() -> None:
    """`go_first`, for a thread that just began."""
    _tell(go_first())


def _tell(what: str) -> None:
    if what:
        say(what)


def go_first() -> str:
    """Have the calling thread run before all others, SCHED_FIFO; what is to be told where that is
    not granted, else ""."""
    try:
        parameters = os.sched_param(FIFO_PRIORITY)
        os.sched_setscheduler(threading.get_native_id(), os.SCHED_FIFO, parameters)
    except OSError as error:
        return f"control: no SCHED_FIFO ({error.strerror}): it runs as other threads do"
    return ""


def keep_little() -> None:
    """Have malloc, where it is glibc's, give large blocks back when they are freed, however many
    come and go: by itself it keeps ever larger ones, in between smaller ones that stay."""
    mallopt = getattr(ctypes.CDLL(None), "mallopt", None)
    if mallopt is not None:
        mallopt(_M_MMAP_THRESHOLD, _OWN_BYTES)


def lock_memory() -> str:
    """Keep in memory what was touched. Where the system limits what may be locked nothing is, for
    what is beyond the limit could not be had at all. What is to be told, else ""."""
    if refused := may_lock():
        return refused
    libc = ctypes.CDLL(None, use_errno=True)
    if libc.mlockall(_MCL_CURRENT | _MCL_FUTURE | _MCL_ONFAULT) != 0:
        why = os.strerror(ctypes.get_errno())
        return f"memory: not locked ({why}): it may be swapped out"
    return ""


def may_lock() -> str:
    """What is to be told where memory may not be locked, else ""; nothing is."""
    unlimited = resource.getrlimit(resource.RLIMIT_MEMLOCK)[0] == resource.RLIM_INFINITY
    if unlimited or _may_lock_all():
        return ""
    return "memory: not locked (RLIMIT_MEMLOCK is limited): it may be swapped out"


def _may_lock_all() -> bool:
    """Whether the limit does not hold for this process: CAP_IPC_LOCK."""
    status = Path("/proc/self/status").read_text(encoding="ascii")
    granted = next(line.split()[1] for line in status.splitlines() if line.startswith("CapEff:"))
    return bool(int(granted, 16) >> _CAP_IPC_LOCK & 1)


class EndSignal:
    """Whether SIGTERM or SIGINT has come: true from the moment on in which the kernel delivers it.
    Python calls its handlers in the main thread alone, when that is done with what it computes;
    here any thread may ask, and is told without waiting for it. Made in the main thread."""

    def __init__(self) -> None:
        self._come = False
        self._read, self._write = socket.socketpair()
        for end in (self._read, self._write):
            end.setblocking(False)
        for name in (signal.SIGTERM, signal.SIGINT):
            signal.signal(name, self._take)
        signal.set_wakeup_fd(self._write.fileno(), warn_on_full_buffer=False)

    def __call__(self) -> bool:
        if not self._come:
            with suppress(BlockingIOError):
                told = self._read.recv(64)
                self._come = bool(set(told) & {signal.SIGTERM, signal.SIGINT})
        return self._come

    def _take(self, *_: object) -> None:
        self._come = True


@contextmanager
def heard_signals() -> Iterator[EndSignal]:
    """An `EndSignal` for a while; afterwards signals do what they did before."""
    before = {name: signal.getsignal(name) for name in (signal.SIGTERM, signal.SIGINT)}
    try:
        yield EndSignal()
    finally:
        signal.set_wakeup_fd(-1)
        for name, handler in before.items():
            signal.signal(name, handler)


class Garbage:
    """Python's garbage collection, by hand: what was loaded is never looked at again, what a frame
    leaves is collected every few seconds, what a search leaves when it is over. All that lives is
    looked at only then: it holds up control, and the base is at rest."""

    def __init__(self, clock: Clock) -> None:
        self._clock, self._collected_s = clock, clock.now_s()

    def begin(self) -> None:
        """After everything was loaded."""
        gc.collect()
        gc.freeze()
        gc.disable()

    def due(self) -> bool:
        """Whether it is time again."""
        return self._clock.now_s() - self._collected_s >= COLLECT_S

    def collect(self) -> None:
        """What came since the last time, on the road."""
        gc.collect(1)
        self._collected_s = self._clock.now_s()

    def collect_all(self) -> None:
        """When the base is at rest."""
        gc.collect()
        self._collected_s = self._clock.now_s()
