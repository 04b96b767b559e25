"""Jobs as tasks of a Ray cluster (extra `ray`): each in a fresh process of some node.

A node needs this project and its assets; what an episode leaves behind is sent to the driver.
"""

import queue
import tempfile
import threading
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from hil_sim.driving.episode_result import EpisodeResult
from hil_sim.driving.link import HarnessError
from hil_sim.evaluation.worker import Drive, Failure, Job, Message, Settings, drive
from runtime.errors import RfNavError

LARGEST_BYTES = 20_000_000
"""A file of an episode's folder that is larger stays on its node."""


@dataclass(frozen=True)
class Files:
    """What an episode left behind, by its path in OUT."""

    content: dict[str, bytes]


@contextmanager
def remote(
    jobs: Sequence[Job], settings: Settings, address: str, target: Drive = drive
) -> Iterator[Iterator[Message]]:
    """Messages of the jobs, as they come; what still runs is ended when the block is left.
    `address` as for `ray.init`: "auto", "ray://HOST:10001", or "local" for one made here."""
    ray = _ray()
    try:
        ray.init(address, log_to_driver=False, configure_logging=False)
    except (ConnectionError, ValueError, RuntimeError) as error:
        raise HarnessError(f"ray: {address}: {str(error).splitlines()[0]}") from error
    task = ray.remote(num_cpus=1, max_calls=1, max_retries=0)(_stream)
    sent = replace(settings, config=None)
    config = settings.config.read_text(encoding="utf-8") if settings.config else ""
    try:
        streams = {
            task.options(num_returns="streaming").remote(job, sent, config, target): job
            for job in jobs
        }
        yield _messages(ray, streams, settings.out)
    finally:
        ray.shutdown()


def _ray() -> Any:
    try:
        import ray
    except ImportError:
        raise HarnessError("ray: not installed; pip install 'rf-nav[ray]'") from None
    return ray


def _messages(ray: Any, streams: dict[Any, Job], out: Path) -> Iterator[Message]:
    """Of all streams, each message as soon as it is there."""
    while streams:
        ready, _ = ray.wait(list(streams), num_returns=1)
        for stream in ready:
            try:
                message = ray.get(next(stream))
            except StopIteration:
                del streams[stream]
                continue
            except ray.exceptions.RayError as error:
                job = streams.pop(stream)
                why = str(error).strip().splitlines()[-1]
                said = f"the task for {job.scene} failed: {why}; run again to go on"
                message = Failure(said, scene=job.scene, died=True)
            if isinstance(message, Files):
                _keep(out, message)
            else:
                yield message


def _keep(out: Path, files: Files) -> None:
    for name, content in files.content.items():
        path = out / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(content)


def _stream(job: Job, settings: Settings, config: str, target: Drive) -> Iterator[Message | Files]:
    """One job on a node: its messages, and before each result the files that belong to it."""
    said: queue.SimpleQueue[Message | None] = queue.SimpleQueue()
    with tempfile.TemporaryDirectory(prefix="rf-nav-task-") as name:
        folder = Path(name)
        mine = replace(settings, out=folder)
        if config:
            (folder / "config.toml").write_text(config, encoding="utf-8")
            mine = replace(mine, config=folder / "config.toml")
        thread = threading.Thread(target=_talk, args=(job, mine, target, said), daemon=True)
        thread.start()
        while (message := said.get()) is not None:
            if isinstance(message, EpisodeResult):
                yield Files(_left(folder, f"{message.method}/{message.episode}"))
            yield message
        thread.join()
        yield Files(_left(folder, "logs"))


def _talk(
    job: Job, settings: Settings, target: Drive, said: "queue.SimpleQueue[Message | None]"
) -> None:
    try:
        target(job, settings, said.put)
    except RfNavError as error:
        said.put(Failure(str(error), scene=job.scene))
    finally:
        said.put(None)


def _left(folder: Path, part: str) -> dict[str, bytes]:
    """The files under a part of a folder."""
    files = sorted(path for path in (folder / part).rglob("*") if path.is_file())
    small = (path for path in files if path.stat().st_size <= LARGEST_BYTES)
    return {str(path.relative_to(folder)): path.read_bytes() for path in small}
