"""Values that the parts exchange. SI units, radians, stamps in integer nanoseconds; frames as in
ARCHITECTURE.md: the map frame is the odometry frame (x forward at the start, y left, z up)."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import StrEnum

import numpy as np
from numpy.typing import NDArray

from runtime.core.belief import Ahead, Belief, Evidence, Taken
from runtime.core.keys import key

F16 = NDArray[np.float16]
F32 = NDArray[np.float32]
F64 = NDArray[np.float64]
I32 = NDArray[np.int32]
U8 = NDArray[np.uint8]
Mask = NDArray[np.bool_]


@dataclass(frozen=True)
class Pose:
    """The base in the map frame: metres, yaw counter-clockwise in (-pi, pi]."""

    x_m: float
    y_m: float
    yaw_rad: float

    @property
    def xy(self) -> F64:
        """(2,) position, m."""
        return np.array([self.x_m, self.y_m])


@dataclass(frozen=True)
class Twist:
    """A differential drive's velocity: forward m/s, yaw rate rad/s counter-clockwise."""

    v_mps: float = 0.0
    w_radps: float = 0.0


@dataclass(frozen=True)
class Intrinsics:
    """A pinhole camera without distortion: focal lengths and principal point in pixels."""

    fx: float
    fy: float
    cx: float
    cy: float
    width: int
    height: int


@dataclass(frozen=True)
class Mount:
    """The camera in the base frame (x forward, y left, z up); a level, forward camera has angles 0.
    Positive pitch looks down (right-handed about y)."""

    x_m: float = key(
        0.0, "How far the camera is ahead of the base's middle.", "m", within=(-3.0, 3.0)
    )
    y_m: float = key(0.0, "How far it is to the left of it.", "m", within=(-3.0, 3.0))
    z_m: float = key(0.88, "Its height above the floor.", "m", within=(0.02, 3.0))
    roll_rad: float = key(
        0.0,
        "Its turn about the axis that it looks along; positive leans right.",
        "rad",
        within=(-3.2, 3.2),
    )
    pitch_rad: float = key(0.0, "Its tilt; positive looks down.", "rad", within=(-1.6, 1.6))
    yaw_rad: float = key(
        0.0, "Its turn about the vertical; positive looks left.", "rad", within=(-3.2, 3.2)
    )


@dataclass(frozen=True)
class Scan:
    """What a level laser scanner met, in the map frame: where it stood, m; by beam its heading,
    rad, and how far what it met was, m, 0 where nothing came back. (N,) each."""

    at_xy: tuple[float, float]
    headings_rad: F64
    ranges_m: F32


@dataclass(frozen=True)
class Observation:
    """One matched set of sensor data: colour, depth and odometry at one stamp."""

    stamp_ns: int
    rgb: U8  # (H, W, 3)
    depth_m: F32  # (H, W) along the optical axis; 0 or NaN is invalid
    pose: Pose
    intrinsics: Intrinsics
    mount: Mount | None = None  # at that stamp, where somebody reports it
    scan: Scan | None = None  # of about that time, where there is a laser
    solid_m: F32 | None = None  # depth without flying pixels, where that is known already


@dataclass(frozen=True)
class Detections:
    """What the detector saw in one image. N boxes, R room types."""

    boxes_px: F32  # (N, 4) x0, y0, x1, y1
    scores: F32  # (N,) in [0, 1]
    labels: I32  # (N,) index into the vocabulary's classes
    embeddings: F32  # (N, D) unit rows; D = 0 for a detector with a fixed class list
    rooms: F32  # (R,) probabilities of the vocabulary's room types, or (0,)
    scene: F32 = field(default_factory=lambda: np.zeros(0, np.float32))
    """(D,) unit embedding of the whole image in the text encoder's space, or (0,)."""
    depths_m: F32 = field(default_factory=lambda: np.zeros(0, np.float32))
    """(N,) depth of each object's own pixels where the detector knows it, else (0,)."""
    features: F32 = field(default_factory=lambda: np.zeros((0, 0, 0), np.float32))
    """(C, h, w) what the detector's backbone has of each part of the image, letterboxed and
    centred to w : h, or (0, 0, 0)."""


@dataclass
class Hint:
    """Where a goal was said to be: `near` things, in `rooms`, by the names that those have on the
    map; and what was visited of it. `before`: things, by id, that an earlier search has seen."""

    near: tuple[str, ...] = ()
    rooms: tuple[str, ...] = ()
    before: frozenset[int] = frozenset()
    visited: set[int] = field(default_factory=set)  # things, by id
    places: int = 0  # of rooms, so far
    place_xy: tuple[float, float] | None = None  # that is gone to, m
    asked_s: float = -10.0  # when a place was asked for last


@dataclass(frozen=True)
class Frontier:
    """A connected boundary of free and unknown space."""

    id: int
    cells_xy: F64  # (N, 2) m, the frontier's cells
    goal_xy: tuple[float, float]  # its reachable cell nearest the robot, m
    distance_m: float  # geodesic from the robot over known free space; inf if unreachable

    @property
    def centre_xy(self) -> tuple[float, float]:
        """Mean of the cells, m; may lie in unknown space or inside an obstacle."""
        x, y = self.cells_xy.mean(axis=0)
        return float(x), float(y)


@dataclass(frozen=True)
class NearbyObject:
    """An object as an expert hears of it: what, how sure, how far from the frontier on foot."""

    name: str
    confidence: float  # [0, 1]
    distance_m: float


UNWRITTEN = {"written": False}
"""Metadata of a field that goes into no journal and no recording: it is a picture, or follows from
what is there."""


@dataclass(frozen=True, eq=False)
class Sight:
    """A keyframe as an expert that sees is shown it toward one frontier. Equal to itself alone."""

    features: F16  # (C, h, w) of the image's parts, as in `Detections`
    depth: F16  # (2, h, w) of the same parts: mean depth, m, and the share that is known
    column: float  # where the frontier is, 0 left to 1 right of the letterboxed image
    range_m: float  # how far on the floor from where the robot stood


@dataclass(frozen=True)
class InImage:
    """Where a frontier is in the image that is kept of it."""

    column: float  # 0 left to 1 right
    row: float  # 0 top to 1 bottom
    range_m: float  # how far on the floor from where the robot stood


@dataclass(frozen=True)
class FrontierBrief:
    """What is known about one frontier."""

    id: int
    distance_m: float  # geodesic from the robot
    objects: tuple[NearbyObject, ...]  # sorted by distance, then name
    rooms: tuple[tuple[str, float], ...]  # room type and probability, vocabulary order; or empty
    view: F32 = field(default_factory=lambda: np.zeros(0, np.float32), compare=False, repr=False)
    """(D,) embedding of the keyframe that looks toward it best, or (0,)."""
    image: bytes = field(default=b"", compare=False, repr=False)
    """That keyframe as a JPEG, b"" when none is kept."""
    doorway: bool = False  # it fills a gap between obstacles: what is behind is another room
    unknown_m2: float = 0.0  # unknown area behind it, close by
    sight: Sight | None = field(default=None, compare=False, repr=False, metadata=UNWRITTEN)
    """That keyframe toward it, where the detector tells what it saw; else None."""
    in_image: InImage | None = field(default=None, compare=False, repr=False)
    """Where it is in `image`; None where that is not known."""


@dataclass(frozen=True)
class Brief:
    """Everything the experts are asked about: an immutable snapshot, frontiers sorted by id."""

    goal: str
    stamp_ns: int
    frontiers: tuple[FrontierBrief, ...]
    order: tuple[int, ...] = field(default=(), compare=False)
    """How the fallback ranks them; () is by distance. Experts do not hear of it."""
    ahead: Ahead | None = field(default=None, compare=False, repr=False, metadata=UNWRITTEN)
    """How they lie to one another, where their order is planned."""


@dataclass(frozen=True)
class Vote:
    """An expert's recommendation: a set of frontiers, the probabilities behind it, and why."""

    expert: str
    frontiers: tuple[int, ...]  # sorted ids, never empty
    probabilities: tuple[tuple[int, float], ...]  # (id, p), sorted by id
    reason: str
    rung: str = "local"  # which of its models answered
    against: tuple[int, ...] = ()  # frontiers it speaks against; see `ConsensusConfig.veto`
    reasons: tuple[tuple[int, str], ...] = ()
    """(id, why) of each frontier of the set, sorted by id; () when the reason is of all at once."""
    reply: str = field(default="", compare=False, repr=False)
    """What a model that answers in words said, as it said it."""
    nats: tuple[tuple[int, float], ...] = ()  # (id, evidence without unknown areas), sorted by id

    def reason_for(self, frontier: int) -> str:
        """What was said of this frontier, where reasons are given by frontier; else all of it."""
        return dict(self.reasons).get(frontier, self.reason)


class Absence(StrEnum):
    """Why an expert did not vote."""

    OUT = "still out"  # in a ballot that is looked at while the round goes on
    LATE = "late"
    BUSY = "busy"  # still with the question before
    SETTLED = "settled without it"
    NO_EVIDENCE = "no evidence"
    NO_PREFERENCE = "no preference"
    ABSTAINS = "abstains"
    NO_IMAGES = "no images"
    PRIVACY = "privacy"
    NONSENSE = "nonsense"
    ERROR = "error"
    NO_TIME = "no time"  # too little is left to begin a call
    AT_REST = "left alone after"  # a failure, for a while
    NOT_AFFORDED = "nothing may be spent"  # or the call could cost more than a cap leaves
    CALL_FAILED = "the call failed"
    HAS_VOTED = "the cloud has voted"  # so an appeal to it would bring nothing new
    NO_MODEL = "no model"  # none could be asked, or none answered

    @property
    def is_answer(self) -> bool:
        """Whether it is the expert's own word: it has looked, and recommends nothing."""
        return self in (Absence.NO_EVIDENCE, Absence.NO_PREFERENCE, Absence.ABSTAINS)

    @property
    def is_told_by_detail(self) -> bool:
        """Whether the detail, where there is one, already says all of it."""
        return self in (Absence.NOT_AFFORDED, Absence.CALL_FAILED, Absence.NO_MODEL)


@dataclass(frozen=True)
class Missing:
    """An expert that did not vote, and why."""

    expert: str
    why: Absence
    detail: str = ""
    reply: str = field(default="", compare=False, repr=False)  # as a vote's
    nats: tuple[tuple[int, float], ...] = field(default=(), compare=False)  # as a vote's

    @property
    def cause(self) -> str:
        """The same for people."""
        if not self.detail:
            return self.why.value
        return self.detail if self.why.is_told_by_detail else f"{self.why.value}: {self.detail}"

    def told(self) -> dict[str, object]:
        """As it is journaled and published."""
        said: dict[str, object] = {"nats": self.nats} if self.nats else {}
        return {"expert": self.expert, "cause": self.cause, **said}


@dataclass(frozen=True)
class Ballot:
    """What the panel returned, sorted by expert name."""

    votes: tuple[Vote, ...] = ()
    missing: tuple[Missing, ...] = ()
    latency_s: Mapping[str, float] = field(default_factory=dict)  # by expert, answered ones


@dataclass(frozen=True)
class Decision:
    """The elected frontier and everything that explains it."""

    frontier: int | None  # None: no reachable frontier is left
    rule: str  # "all" | "pairs" | "lone" | "best" | "majority" | the fallback's | "none"
    chosen: tuple[int, ...]  # the consensus set, sorted; ranked by distance to elect one of it
    closest: int | None  # what the fallback would have been
    ballot: Ballot
    stamp_ns: int
    why: str  # the event that made it due
    without: tuple[tuple[str, int | None], ...] = ()
    """By expert that was heard: what would have been elected without its word."""
    order: tuple[int, ...] = field(default=(), metadata=UNWRITTEN)  # of looks, where planned
    belief: Belief | None = field(default=None, repr=False, metadata=UNWRITTEN)
    """Where the thing may be, where that is worked out."""
    said: Evidence = field(default_factory=dict, repr=False, metadata=UNWRITTEN)
    """What experts have said of frontiers so far, where that is remembered."""
    taken: Taken | None = field(default=None, compare=False, repr=False, metadata=UNWRITTEN)


class Action(StrEnum):
    """The discrete actions of the object-goal protocols."""

    MOVE_FORWARD = "move_forward"
    TURN_LEFT = "turn_left"
    TURN_RIGHT = "turn_right"
    STOP = "stop"


class SearchState(StrEnum):
    """How a search stands; from the third on, how it ended."""

    READY = "ready"
    SEARCHING = "searching"
    FOUND = "found"
    ARRIVED = "arrived"  # where it was to go to
    NOT_FOUND = "not_found"
    UNREACHABLE = "unreachable"  # it is believed to be seen, or known, and no way leads there
    CANCELLED = "cancelled"
    PREEMPTED = "preempted"  # by another goal
    TIMED_OUT = "timed_out"
    AREA_LEFT = "area_left"  # that the goal was bound to
    FAILED = "failed"
    ENDED = "ended"  # with the runtime: a restart may go on

    @property
    def over(self) -> bool:
        """Whether its goal is done with: none has taken its place, and no restart goes on."""
        return self not in (self.READY, self.SEARCHING, self.PREEMPTED, self.ENDED)
