"""Homes that are made one in a process of its own, since EGL cannot draw a second one; those that
are finished are kept."""

import multiprocessing
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool

from tqdm import tqdm

from runtime.errors import RfNavError


def make_homes(
    names: Sequence[str], todo: Sequence[str], workers: int, make: Callable[[str], None]
) -> None:
    """Make those to do of all these homes. What goes wrong in one ends it; RfNavError where a
    worker dies."""
    spawn = multiprocessing.get_context("spawn")
    with (
        tqdm(total=len(names), initial=len(names) - len(todo), unit="home", disable=None) as bar,
        ProcessPoolExecutor(workers, mp_context=spawn, max_tasks_per_child=1) as pool,
    ):
        jobs = [pool.submit(make, name) for name in todo]
        try:
            for job in as_completed(jobs):
                job.result()
                bar.update()
        except BrokenProcessPool:
            raise RfNavError("a worker died (out of memory?); run again to go on") from None
        except BaseException:
            pool.shutdown(cancel_futures=True)  # those under way end first
            raise
