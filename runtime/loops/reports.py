"""What a search tells of itself: a decision as it is published and logged, and the map that it
leaves behind."""

from typing import Any

import numpy as np

from runtime.core.inventory import inventory
from runtime.core.mapping.drops import DROP_AT
from runtime.core.types import Action, Decision
from runtime.core.voting import consensus
from runtime.core.voting.explain import in_words
from runtime.core.voting.taken import in_words as taken_in_words
from runtime.core.world import Command, World
from runtime.perception.goal_words import Goal


def explain(decision: Decision, world: World, rank: str) -> dict[str, object]:
    """A decision as it is published and logged: what was elected, by whom, and why; what would have
    been without each expert; and where it leads on the map of now (`heads_for`), as frontiers may
    have gone while the vote ran."""
    return {
        "step": world.body.step,
        "stamp_ns": decision.stamp_ns,
        "why": decision.why,
        "frontier": decision.frontier,
        "rule": decision.rule,
        "chosen": decision.chosen,
        "closest": decision.closest,
        "heads_for": consensus.successor(decision, world.frontiers, rank),
        "in_words": in_words(decision),
        "order": decision.order,
        "belief": told_belief(decision),
        "taken": told_taken(decision),
        "without": dict(decision.without),
        "votes": decision.ballot.votes,
        "missing": decision.ballot.missing,
        "latency_s": {k: round(v, 4) for k, v in decision.ballot.latency_s.items()},
        "frontiers": [
            {
                "id": f.id,
                "goal_xy": f.goal_xy,
                "distance_m": f.distance_m,
                "cells": len(f.cells_xy),
            }
            for f in world.frontiers
        ],
    }


def told_belief(decision: Decision | None) -> dict[str, object] | None:
    """Where the thing may be, as it is published; None where that is not worked out."""
    return decision.belief.told() if decision is not None and decision.belief is not None else None


def told_taken(decision: Decision) -> dict[str, object] | None:
    """What the elected frontier was taken for, as it is published; None where there is none."""
    if decision.taken is None:
        return None
    ballot = decision.ballot
    words = taken_in_words(decision.taken, asked=bool(ballot.votes or ballot.missing))
    return decision.taken.told() | {"in_words": words}


def map_of(world: World, goal: Goal) -> tuple[dict[str, np.ndarray[Any, Any]], dict[str, object]]:
    """What `map.npz` holds: grids over one frame, and the rest as metadata."""
    last = world.body.last
    arrays: dict[str, np.ndarray[Any, Any]] = {
        "occupied": world.map.occupied,
        "free": world.map.free,
        "drops": world.map.drops >= DROP_AT,
        "rooms": world.semantic.rooms.astype(np.float16),
        "path_xy": np.array(world.body.visited_xy).reshape(-1, 2),
        "planned_xy": last.path_xy if last else np.zeros((0, 2)),
    }
    frame, decision = world.map.frame, world.standing.decision
    stopped = last is not None and last.action is Action.STOP
    meta: dict[str, object] = {
        "goal": goal.text,
        "goal_name": goal.name,
        "frame": frame,
        "room_names": world.semantic.room_names,
        "pose": world.pose,
        "frontiers": [
            {"id": f.id, "cells_xy": f.cells_xy.round(3), "distance_m": f.distance_m}
            for f in world.frontiers
        ],
        "elected": decision.frontier if decision else None,
        "stopped_at": last.toward_xy if last is not None and stopped else None,
        "objects": inventory(world),
    }
    return arrays, meta


def told_command(world: World, command: Command) -> dict[str, object]:
    """What the loop wants of the base, and the frontiers that it knew: what a replay compares."""
    return {
        "step": world.body.step,
        "action": command.action,
        "mode": command.mode,
        "reason": command.reason,
        "toward_xy": command.toward_xy,
        "ended": command.ended,
        "path_xy": command.path_xy,
        "frontiers": [(f.id, f.distance_m) for f in world.frontiers],
        "objects": len(world.semantic.instances),
    }
