"""Jobs in processes of this machine, each a fresh one."""

import multiprocessing
import signal
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from multiprocessing import connection
from multiprocessing.context import SpawnProcess

from hil_sim.evaluation.worker import Failure, Job, Message, Settings, work

Work = Callable[[Job, Settings, connection.Connection], None]
Running = dict[connection.Connection, tuple[SpawnProcess, Job]]


@contextmanager
def local(
    jobs: Sequence[Job], settings: Settings, workers: int, target: Work = work
) -> Iterator[Iterator[Message]]:
    """Messages of at most `workers` processes; all have ended when the block is left."""
    running: Running = {}
    try:
        yield _messages(list(jobs), settings, workers, target, running)
    finally:
        for process, _ in running.values():
            process.terminate()
        for process, _ in running.values():
            process.join(5.0)
            if process.is_alive():
                process.kill()
                process.join()


def _messages(
    waiting: list[Job], settings: Settings, workers: int, target: Work, running: Running
) -> Iterator[Message]:
    while waiting or running:
        while waiting and len(running) < workers:
            _start(waiting.pop(0), settings, target, running)
        for ready in connection.wait(list(running)):
            assert isinstance(ready, connection.Connection)
            try:
                yield ready.recv()
            except EOFError:
                process, job = running.pop(ready)
                process.join()
                if process.exitcode:
                    yield Failure(
                        f"the worker for {job.scene} ended with status {process.exitcode}; "
                        "run again to go on",
                        scene=job.scene,
                        died=True,
                    )


def _start(job: Job, settings: Settings, target: Work, running: Running) -> None:
    spawn = multiprocessing.get_context("spawn")
    ours, theirs = spawn.Pipe(duplex=False)
    process = spawn.Process(target=target, args=(job, settings, theirs))
    # Ctrl-C reaches every process of the terminal; children inherit the block, so that only
    # the parent acts on it.
    signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        process.start()
        running[ours] = (process, job)  # before an interrupt can come: it will be ended
    finally:
        signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT})
    theirs.close()
