"""Homes that are made one in a process of its own, since EGL cannot draw a second one; those that
are finished are kept, in a folder that says how they were made."""

import dataclasses
import json
import multiprocessing
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from pathlib import Path
from typing import Any, TypeVar

from tqdm import tqdm

from runtime.errors import RfNavError

P = TypeVar("P", bound=Any)


def claim(path: Path, plan: Any) -> None:
    """Say in this file how homes are made, or check that it says the same: `plan` is a dataclass.
    RfNavError when it says another thing, or nothing that can be read."""
    ours = dataclasses.asdict(plan)
    if not path.is_file():
        path.write_text(json.dumps(ours, indent=1) + "\n", encoding="utf-8")
        return
    theirs = dataclasses.asdict(plan_in(path, type(plan)))
    changed = sorted(key for key in ours if theirs[key] != ours[key])
    if changed:
        raise RfNavError(f"{path}: was made with other {', '.join(changed)}; use another folder")


def plan_in(path: Path, kind: type[P]) -> P:
    """How homes were made, as this file says; RfNavError when it says nothing that can be read."""
    try:
        found: P = kind(**json.loads(path.read_text(encoding="utf-8")))
    except (OSError, TypeError, ValueError) as error:
        raise RfNavError(f"{path}: not a plan of homes ({error}); use another folder") from error
    return found


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
