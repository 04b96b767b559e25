"""How long a thread is at work on something, whatever else the machine does."""

from collections.abc import Callable, Iterable
from time import thread_time
from typing import Final

import numpy as np

TURNS: Final = 100


def own_ms(work: Callable[[], object], turns: int = TURNS) -> tuple[float, float]:
    """Processor time of this thread: the median, and of the slowest tenth the least."""
    took_ms = []
    for _ in range(turns):
        began_s = thread_time()
        work()
        took_ms.append(1e3 * (thread_time() - began_s))
    p50, p90 = np.percentile(took_ms, [50, 90])
    return float(p50), float(p90)


def print_stages(stages: Iterable[tuple[str, Callable[[], object]]]) -> None:
    """A line for each: both, ms."""
    for name, work in stages:
        p50, p90 = own_ms(work)
        print(f"{name:32}{p50:7.2f}{p90:7.2f} ms")
