"""What the scene-layout expert is punished for, of evidence in nats, whoever gives it."""

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor
from torch.nn import functional as F

from models.train.beyond_data import Homes
from models.train.beyond_scores import LEAST_M2, TEMPERATURE, UNKNOWN_WEIGHT

WALK_M = 1.5
"""So much farther on is exp(-1) as good."""
LEAST_AREA_M2 = 0.3
"""With less floor beyond, no room type is."""


class LayoutFacts:
    """What is true of each row and frame of some homes, as tensors. `taught` (K,) bool."""

    def __init__(self, homes: Homes, taught: NDArray[np.bool_]) -> None:
        known = homes.known() & taught
        there = homes.there() & known
        self.known = torch.from_numpy(known)
        self.there = torch.from_numpy(there)
        self.usual = usual(there, known)
        in_view = homes.in_view & taught
        self.in_view = torch.from_numpy(in_view)
        self.usual_view = usual(in_view, np.broadcast_to(taught, in_view.shape))
        self.taught = torch.from_numpy(taught)
        onward = np.where(homes.asked & taught, homes.onward_m.astype(np.float32), np.inf)
        self.onward = torch.from_numpy(onward.astype(np.float32))
        prior = UNKNOWN_WEIGHT * np.log(homes.unknown_m2.astype(np.float32) + LEAST_M2)
        self.prior = torch.from_numpy(prior)
        self.area = torch.from_numpy(np.log(homes.area_m2.astype(np.float32) + LEAST_M2))
        room = homes.room_m2.astype(np.float32)
        self.rooms = torch.from_numpy(room)
        self.room = torch.from_numpy(homes.room.astype(np.int64))


def usual(there: NDArray[np.bool_], known: NDArray[np.bool_]) -> Tensor:
    """(N, K) twice -> (K,) log odds of each by themselves."""
    share = (there.sum(axis=0) + 1) / (known.sum(axis=0) + 2)
    return torch.from_numpy(np.log(share / (1 - share)).astype(np.float32))


def beyond_loss(evidence: Tensor, facts: LayoutFacts, rows: Tensor) -> Tensor:
    """(N, K) nats above what is usual: is there one beyond?"""
    return told_apart(evidence + facts.usual, facts.there[rows], facts.known[rows])


def view_loss(evidence: Tensor, facts: LayoutFacts, frames: Tensor) -> Tensor:
    """(F, K) nats above what is usual: is there one in view?"""
    known = facts.taught.expand(len(frames), -1)
    return told_apart(evidence + facts.usual_view, facts.in_view[frames], known)


def told_apart(odds: Tensor, there: Tensor, known: Tensor) -> Tensor:
    """Mean binary cross entropy of what is known."""
    each = F.binary_cross_entropy_with_logits(odds, there.float(), reduction="none")
    return (each * known).sum() / known.sum().clamp(min=1)


def onward_loss(evidence: Tensor, facts: LayoutFacts, rows: Tensor) -> Tensor:
    """`evidence` (M, G, K) of moments' frontiers, `rows` (M, G), -1 for none: the vote should like
    frontiers from which the way on is short, with its prior and without. Mean divergence, nats."""
    there = (rows >= 0)[..., None]
    at = rows.clamp(min=0)
    onward = torch.where(there, facts.onward[at], torch.inf)
    counted = onward.isfinite()
    asked = counted.sum(1) >= 2
    wanted = (-onward / WALK_M).masked_fill(~counted, -1e4).softmax(1)
    wanted_log = wanted.clamp(min=1e-9).log()
    apart = torch.zeros_like(wanted[:, 0])
    for votes in (evidence, evidence + facts.prior[at][..., None]):
        log_p = (votes / TEMPERATURE).masked_fill(~counted, -1e4).log_softmax(1)
        apart = apart + (wanted * (wanted_log - log_p)).sum(1) / 2
    return (apart * asked).sum() / asked.sum().clamp(min=1)


def room_loss(odds: Tensor, shares: Tensor) -> Tensor:
    """(N, R) log odds of room types, (N, R) how much there is of each; rows without count not."""
    total = shares.sum(1)
    counted = total > LEAST_AREA_M2
    wanted = shares / total.clamp(min=1e-6)[:, None]
    each = -(wanted * odds.log_softmax(1)).sum(1)
    return (each * counted).sum() / counted.sum().clamp(min=1)
