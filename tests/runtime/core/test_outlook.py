"""What a decision is made on does not change with the world, whenever it is worked out."""

import math
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
from apartment import MOUNT, TWO_ROOMS, Apartment

from runtime import navigate
from runtime.core.exploration import with_frontiers
from runtime.core.mapping import keyframes
from runtime.core.objects.instances import Evidence, Instance
from runtime.core.types import Ballot, Brief, Decision, Pose, Vote
from runtime.core.voting import brief
from runtime.core.voting.consensus import ConsensusConfig
from runtime.core.world import World

NAMES, ROOMS = ("toilet", "sofa", "bed"), ("bathroom", "bedroom")
CFG = navigate.NavigateConfig()


def looked_around(turns: int) -> tuple[World, Apartment]:
    home = Apartment.of(TWO_ROOMS, Pose(4.0, 3.0, 0.0))
    home.things = {"bed": (5.2, 3.2, 0.3)}
    world = World.begin("toilet", NAMES, ROOMS, home.pose, 0.18)
    look(world, home, turns)
    return world, home


def look(world: World, home: Apartment, turns: int) -> None:
    for n in range(turns):
        home.pose = Pose(home.pose.x_m, home.pose.y_m, n * math.pi / 6)
        obs = home.observe()
        navigate.perceive(world, obs, home.detect(NAMES, obs), MOUNT, CFG)


def test_it_tells_what_the_world_itself_would():
    world, _ = looked_around(5)
    frontier = next(f for f in world.frontiers if math.isfinite(f.distance_m))
    cells = np.array([frontier.goal_xy])
    world.semantic.instances[99] = Instance(
        99, {"sofa": Evidence(4.0)}, frontier.goal_xy, 0.4, cells
    )
    reachable = [f for f in world.frontiers if math.isfinite(f.distance_m)]
    cells = {f.id: f.cells_xy for f in reachable}
    views = keyframes.best_views(world.keyframes, cells, world.map)
    told = brief.compose("toilet", world.stamp_ns, world.map, world.semantic, reachable, views)
    seen = navigate.outlook(world, "test", CFG)
    assert seen.brief.frontiers == brief.worthwhile(told, 0.1).frontiers
    assert any(f.objects for f in seen.brief.frontiers)
    assert any(f.unknown_m2 > 1 for f in seen.brief.frontiers)
    assert [f.id for f in seen.frontiers] == [f.id for f in seen.brief.frontiers]


def test_it_copies_what_is_told_of_and_no_more():
    world, _ = looked_around(5)
    small = navigate.outlook(world, "test", CFG)
    here, world.pose = world.pose, Pose(60.0, 50.0, 0.0)
    world.grow(10.0)
    world.pose = here
    with_frontiers(world, CFG)
    large = navigate.outlook(world, "test", CFG)
    assert large.map.frame.shape == large.map.free.shape
    assert {id: rooms.shape for id, rooms in large.semantic.rooms.items()} == {
        f.id: (len(ROOMS),) for f in large.candidates
    }
    assert max(large.map.frame.shape) < min(world.map.frame.shape) / 2
    assert large.brief == small.brief


def test_worked_out_later_it_tells_what_was_known_when_it_was_taken():
    world, home = looked_around(4)
    at_once, later = (navigate.outlook(world, "test", CFG) for _ in range(2))
    told = at_once.snapshot
    home.things = {"sofa": (3.2, 3.2, 0.3)}
    home.pose = Pose(3.0, 3.0, 0.0)
    look(world, home, 12)
    assert later.snapshot.brief == told.brief
    assert later.snapshot.brief != navigate.snapshot(world, "test", CFG).brief


def test_without_a_frontier_it_tells_of_none():
    world, _ = looked_around(2)
    world.frontiers = ()
    assert navigate.outlook(world, "test", CFG).brief.frontiers == ()


def test_where_the_order_is_planned_it_tells_how_frontiers_lie_to_one_another():
    world, _ = looked_around(5)
    cfg = navigate.NavigateConfig(consensus=ConsensusConfig(mode="prior", fallback="ahead"))
    stood = Decision(3, "prior", (3,), 3, Ballot(), 0, "", said={"o2f": {3: 1.0}})
    navigate.adopt(world, stood)
    told = navigate.outlook(world, "test", cfg).brief
    assert told.ahead is not None
    assert set(told.ahead.ids) == {f.id for f in told.frontiers}
    assert set(told.order) == set(told.ahead.ids)
    assert (told.ahead.standing, told.ahead.before) == (3, stood.said)
    n = len(told.ahead.ids)
    assert told.ahead.between_m.shape == (n, n)
    areas = {f.id: f.unknown_m2 for f in told.frontiers}
    assert dict(zip(told.ahead.ids, told.ahead.unknown_m2, strict=True)) == areas
    unplanned = navigate.NavigateConfig(consensus=ConsensusConfig(fallback="geometry"))
    plain = navigate.outlook(world, "test", unplanned).brief
    assert plain.ahead is not None
    assert plain.ahead.between_m.size == 0
    assert plain.order == plain.ahead.ids
    paper = navigate.NavigateConfig(consensus=ConsensusConfig(fallback="closest"))
    assert navigate.outlook(world, "test", paper).brief.ahead is None


def test_a_decision_by_evidence_is_made_of_the_world_as_it_is():
    world, _ = looked_around(5)
    cfg = navigate.NavigateConfig(consensus=ConsensusConfig(mode="prior", fallback="ahead"))
    snap = navigate.snapshot(world, "test", cfg)
    silent = navigate.decide(snap, Silent(), None, cfg)
    assert (silent.rule, silent.order) == ("ahead", snap.brief.order)
    other = silent.order[1]
    decided = navigate.decide(snap, Pointing(other), None, cfg)
    assert (decided.rule, decided.frontier) == ("prior", other)
    navigate.adopt(world, decided)
    again = navigate.snapshot(world, "test", cfg)
    assert again.brief.ahead is not None
    assert again.brief.ahead.before == decided.said


def test_what_was_said_of_a_frontier_outlives_a_decision_that_it_is_no_part_of():
    world, _ = looked_around(5)
    cfg = navigate.NavigateConfig(consensus=ConsensusConfig(mode="prior", fallback="ahead"))
    snap = navigate.snapshot(world, "test", cfg)
    decided = navigate.decide(snap, Pointing(snap.brief.order[1]), None, cfg)
    navigate.adopt(world, decided)
    reachable, world.frontiers = world.frontiers, ()
    cut_off = navigate.decide(navigate.snapshot(world, "test", cfg), Silent(), None, cfg)
    assert (cut_off.rule, cut_off.said) == ("none", {})
    navigate.adopt(world, cut_off)
    world.frontiers = reachable
    again = navigate.snapshot(world, "test", cfg)
    assert again.brief.ahead is not None
    assert again.brief.ahead.before == decided.said


def test_what_was_said_of_a_frontier_that_is_gone_is_forgotten():
    world, _ = looked_around(5)
    there = next(f.id for f in world.frontiers)
    said = {"o2f": {there: 1.0, there + 1000: -1.0}}
    navigate.adopt(world, Decision(there, "prior", (there,), there, Ballot(), 0, "", said=said))
    assert world.standing.decision is not None
    assert world.standing.decision.said == {"o2f": {there: 1.0}}


class Silent:
    def ask(self, brief: Brief, by: None) -> Ballot:
        return Ballot()


class Pointing:
    """Two experts who are as sure of one frontier as they may be."""

    def __init__(self, at: int) -> None:
        self.at = at

    def ask(self, brief: Brief, by: None) -> Ballot:
        nats = tuple((f.id, 9.0 * (f.id == self.at)) for f in brief.frontiers)
        return Ballot(tuple(Vote(e, (self.at,), (), "there", nats=nats) for e in ("o2f", "r2f")))


def test_surfaces_that_were_not_seen_finely_are_places_too():
    world, _ = looked_around(5)
    cfg = navigate.NavigateConfig(consensus=ConsensusConfig(fallback="ahead"))
    patch = SimpleNamespace(id="b1", xy=(1.0, 1.0), area_m2=1.0, missed=0.5)
    seen = replace(navigate.outlook(world, "test", cfg), patches=(patch,))
    belief = navigate.decide(seen, Silent(), None, cfg).belief
    assert belief is not None
    assert [place.id for place in belief.places if place.kind == "surface"] == ["b1"]


def test_a_belief_goes_with_a_decision_that_plans_nothing():
    world, _ = looked_around(5)
    cfg = navigate.NavigateConfig(consensus=ConsensusConfig("nearest", "strict", "geometry"))
    snap = navigate.snapshot(world, "test", cfg)
    last = snap.brief.order[-1]
    decided = navigate.decide(snap, Pointing(last), None, cfg)
    assert (decided.rule, decided.frontier, decided.order) == ("all", last, ())
    assert decided.belief is not None
    assert decided.belief.places[0].id == last
