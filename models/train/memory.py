"""How a training process asks for memory."""

import os
import sys

# glibc gives freed activations back to the kernel and faults them in again every step; keeping
# them makes a step several times faster. It must be in the environment before the process starts.
KEEP = {
    "MALLOC_MMAP_THRESHOLD_": str(1 << 33),
    "MALLOC_TRIM_THRESHOLD_": str(1 << 33),
    "MALLOC_TOP_PAD_": str(1 << 28),
    "OMP_WAIT_POLICY": "passive",
}


def keep_memory() -> None:
    """Start this process anew, as it was called, with memory that is kept; once."""
    if any(os.environ.get(key) != value for key, value in KEEP.items()):
        os.execve(sys.executable, [sys.executable, *sys.orig_argv[1:]], {**os.environ, **KEEP})
