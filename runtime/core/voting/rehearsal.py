"""The next decision, prepared while the robot drives to the last: for the map as it will probably
be once the frontier it drives to is explored, the others as they are now.

What was prepared is used only if the experts would have been told the same: the same goal and the
same frontiers by id, and around each the same objects and room types within the tolerances below.
How far the robot is from each does not matter: votes are not about it, the election uses the
distances of now.
"""

from dataclasses import replace

from runtime.core.types import F32, Ballot, Brief, FrontierBrief, Sight

SLOW_S = 0.1  # only when the votes before took so long, or were late
EVERY_S = 1.0  # at most so often
CONFIDENCE_SLACK = 0.1  # an object's may differ so much
DISTANCE_SLACK_M = 0.5  # and its distance from the frontier
ROOMS_SLACK = 0.1  # total variation of two distributions over room types
VIEW_SLACK = 0.05  # one minus the cosine of two views
WAY_SLACK = 0.1, 0.5  # where a frontier stands in the view: share of its width, m
UNKNOWN_SLACK_M2 = 0.5  # unknown area behind a frontier


def worthwhile(ballot: Ballot) -> bool:
    """Whether votes are slow enough to be prepared."""
    if any(not absent.why.is_answer for absent in ballot.missing):
        return True
    return max(ballot.latency_s.values(), default=0.0) >= SLOW_S


def complete(ballot: Ballot) -> bool:
    """Whether asking anew could not bring more votes: nobody was late, busy or broken."""
    return all(absent.why.is_answer for absent in ballot.missing)


def expected(brief: Brief, aim: int) -> Brief:
    """The brief once the frontier `aim` is explored."""
    return replace(brief, frontiers=tuple(f for f in brief.frontiers if f.id != aim))


def differs(prepared: Brief, now: Brief) -> str:
    """The first thing that experts would be told otherwise now; "" when there is none."""
    if prepared.goal != now.goal:
        return "another goal"
    before = {f.id: f for f in prepared.frontiers}
    after = {f.id: f for f in now.frontiers}
    for id in sorted(before.keys() ^ after.keys()):
        return f"frontier {id} is {'new' if id in after else 'gone'}"
    for id, frontier in after.items():
        what = _differ(before[id], frontier)
        if what:
            return f"other {what} at frontier {id}"
    return ""


def _differ(a: FrontierBrief, b: FrontierBrief) -> str:
    if not _same_objects(a, b):
        return "objects"
    p, q = dict(a.rooms), dict(b.rooms)
    apart = sum(abs(p.get(name, 0.0) - q.get(name, 0.0)) for name in p.keys() | q.keys()) / 2
    if bool(p) != bool(q) or apart > ROOMS_SLACK:
        return "rooms"
    if a.doorway != b.doorway:
        return "doorway"
    if abs(a.unknown_m2 - b.unknown_m2) > UNKNOWN_SLACK_M2:
        return "unknown area"
    same = _same_view(a.view, b.view) and _same_way(a.sight, b.sight)
    return "" if same else "view"


def _same_objects(a: FrontierBrief, b: FrontierBrief) -> bool:
    """The same names, and those of one name pair by pair from the nearest on."""
    before = sorted(a.objects, key=lambda o: (o.name, o.distance_m, o.confidence))
    after = sorted(b.objects, key=lambda o: (o.name, o.distance_m, o.confidence))
    return len(before) == len(after) and all(
        x.name == y.name
        and abs(x.distance_m - y.distance_m) <= DISTANCE_SLACK_M
        and abs(x.confidence - y.confidence) <= CONFIDENCE_SLACK
        for x, y in zip(before, after, strict=True)
    )


def _same_view(a: F32, b: F32) -> bool:
    if a.size != b.size:
        return False
    return not a.size or 1.0 - float(a @ b) <= VIEW_SLACK


def _same_way(a: Sight | None, b: Sight | None) -> bool:
    if a is None or b is None:
        return a is b
    across, far_m = WAY_SLACK
    return abs(a.column - b.column) <= across and abs(a.range_m - b.range_m) <= far_m
