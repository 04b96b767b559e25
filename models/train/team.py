"""Processes that train one network together: each learns from its share of the frames, and every
step goes by the mean of their gradients."""

import os
import signal
import tempfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import torch
from torch import Tensor, distributed
from torch.multiprocessing.spawn import spawn

from models.train.labelled import Labelled


@dataclass(frozen=True)
class Team:
    """Who one is among `count` processes. Alone, every method is the identity."""

    rank: int = 0
    count: int = 1

    @property
    def leads(self) -> bool:
        """Whether this one writes checkpoints and says how it goes."""
        return self.rank == 0

    def share(self, frames: Sequence[Labelled]) -> list[Labelled]:
        """One's own part of the leader's list; all parts have one length."""
        if self.count == 1:
            return list(frames)
        said = [list(frames)]
        distributed.broadcast_object_list(said)
        return said[0][: len(said[0]) // self.count * self.count][self.rank :: self.count]

    def mean(self, value: float) -> float:
        """The mean of what everyone says; the same number for all."""
        if self.count == 1:
            return value
        both = torch.tensor([value], dtype=torch.float64)
        distributed.all_reduce(both)
        return float(both) / self.count

    def average_gradients(self, parameters: Sequence[Tensor]) -> None:
        """Put the mean of all members' gradients in place of one's own; none counts as zero."""
        if self.count == 1:
            return
        for p in parameters:
            if p.grad is None:
                p.grad = torch.zeros_like(p)
        mine = [p.grad for p in parameters if p.grad is not None]
        flat = torch.cat([g.reshape(-1) for g in mine])
        distributed.all_reduce(flat)
        flat /= self.count
        parts = torch.split(flat, [g.numel() for g in mine])
        for gradient, part in zip(mine, parts, strict=True):
            gradient.copy_(part.view(gradient.shape))


def together(count: int, work: Callable[[Team], None]) -> None:
    """Do `work` in this process, or in `count` of its own; the first failure ends them all."""
    if count == 1:
        work(Team())
        return
    with tempfile.TemporaryDirectory() as directory:
        spawn(_join, (count, f"file://{directory}/meeting", work), nprocs=count)  # type: ignore[no-untyped-call]


def _join(rank: int, count: int, meeting: str, work: Callable[[Team], None]) -> None:
    # torch has Linux send SIGINT when the parent dies; jobs in a shell's background ignore it.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    os.environ["GLOO_SOCKET_IFNAME"] = "lo"
    distributed.init_process_group("gloo", init_method=meeting, rank=rank, world_size=count)
    # Whoever fails keeps the others waiting until it is gone: else they fail of that, and the first
    # failure to be told is one of theirs.
    work(Team(rank, count))
    distributed.destroy_process_group()
