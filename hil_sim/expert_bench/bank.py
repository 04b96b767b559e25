"""What the experts are asked, with the truth beside it, and the files that hold it.

A moment is a partial map as the robot had it; it is one question for each goal that was not on the
map yet. A bank is a folder: `bank.json` says how it was made, `homes/NAME.jsonl.gz` holds the
moments of one home, one a line, after a line about the home and one with what keyframes showed,
which many frontiers share.
"""

import base64
import gzip
import hashlib
import json
import os
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, get_origin

import numpy as np
from cattrs.gen import make_dict_structure_fn, make_dict_unstructure_fn, override
from cattrs.preconf.json import make_converter

from hil_sim.scenes.open import is_replica
from runtime.core.belief import Ahead
from runtime.core.types import F16, Brief, Frontier, FrontierBrief, NearbyObject, Sight
from runtime.errors import RfNavError

FORMAT = "rf-nav-questions/2"
PLAN_FILE, HOMES = "bank.json", "homes"
CLEAN = "clean"
EQUAL_M = 0.5
"""A question whose worst answer costs less than this more than its best is none."""
SIDES = ("fit", "test")


@dataclass(frozen=True)
class BankPlan:
    """How a bank is made; all of it changes the questions."""

    seed: int = 0
    starts: int = 2  # drives a home
    steps: int = 64  # of a drive, the first look around included
    moments: int = 5  # of a drive at most
    apart: int = 8  # steps between two of them
    goals: int = 8  # a home at most
    wander: float = 0.5  # share of the frontiers driven to that are drawn, not the closest
    wrong: float = 0.2  # share of the objects with another's name, under "wrong labels"
    missing: float = 0.3  # share of the objects left out, under "missing objects"


@dataclass(frozen=True)
class Moment:
    """One partial map. `briefs` by condition, goal "": as the map is, and with its objects
    perturbed; all tell of the same frontiers, those that the runtime chooses among. `order` ranks
    these by information gain. `ids` are all that can be reached, sorted; `goal_xy` (map frame, m)
    and the costs by goal are in their order."""

    home: str
    drive: int
    step: int
    why: str
    briefs: Mapping[str, Brief]
    order: tuple[int, ...]
    ids: tuple[int, ...]
    goal_xy: tuple[tuple[float, float], ...]
    costs_m: Mapping[str, tuple[float, ...]]


@dataclass(frozen=True)
class BankHome:
    """What one home gave. `left_out` counts goals at moments that are no questions, by why;
    `detector` names the detector that saw it."""

    name: str
    moments: tuple[Moment, ...]
    left_out: Mapping[str, int]
    detector: str


@dataclass(frozen=True)
class BenchQuestion:
    """Which frontier to go to for a goal: cost(f) = way to f on the map + true way on from it."""

    moment: Moment
    goal: str
    costs_m: Mapping[int, float]  # by frontier

    @property
    def layout(self) -> str:
        return layout_of(self.moment.home)

    @property
    def regrets_m(self) -> dict[int, float]:
        """By frontier: what choosing it costs more than the best choice."""
        least = min(self.costs_m.values())
        return {id: cost - least for id, cost in self.costs_m.items()}

    def brief(self, condition: str = CLEAN) -> Brief:
        return replace(self.moment.briefs[condition], goal=self.goal)

    def frontiers(self) -> tuple[Frontier, ...]:
        """As an election wants them; of each one's cells only its goal point is kept."""
        place = dict(zip(self.moment.ids, self.moment.goal_xy, strict=True))
        return tuple(
            Frontier(f.id, np.array([place[f.id]], np.float64), place[f.id], f.distance_m)
            for f in self.moment.briefs[CLEAN].frontiers
        )

    def ahead(self) -> Ahead:
        """What evidence is weighed with, without ways between frontiers, of which a bank has none:
        one step is elected by it."""
        told = self.moment.briefs[CLEAN].frontiers
        place = dict(zip(self.moment.ids, self.moment.goal_xy, strict=True))
        areas = tuple(f.unknown_m2 for f in told)
        return Ahead(
            tuple(f.id for f in told),
            tuple(place[f.id] for f in told),
            areas,
            np.array(areas),
            np.array([f.distance_m for f in told]),
        )


@dataclass(frozen=True)
class Bank:
    """Questions of some homes, and how many were left out, by why."""

    questions: tuple[BenchQuestion, ...]
    left_out: Mapping[str, int] = field(default_factory=dict)

    @property
    def homes(self) -> int:
        return len({q.moment.home for q in self.questions})

    @property
    def layouts(self) -> int:
        return len({q.layout for q in self.questions})


def layout_of(home: str) -> str:
    """RoboTHOR's scenes share walls by fives: FloorPlan_Train3 for FloorPlan_Train3_5."""
    return home.rpartition("_")[0] if is_replica(home) else home


def side_of(home: str) -> str:
    """ "fit", where thresholds come from, or "test": by the layout's number, or the home's seed."""
    digits = "".join(c for c in layout_of(home) if c.isdigit())
    return SIDES[int(digits or 0) % 2]


def load_bank(folder: Path, side: str = "all") -> Bank:
    """The questions of one side, or of both; RfNavError when the folder holds none."""
    found, left_out, detectors = [], dict[str, int](), set()
    for path in sorted((folder / HOMES).glob("*.jsonl.gz")):
        name = path.name.removesuffix(".jsonl.gz")
        if side not in ("all", side_of(name)):
            continue
        home = read_home(path)
        detectors.add(home.detector)
        questions = list(questions_of(home))
        found += questions
        count = sum(len(moment.costs_m) for moment in home.moments) - len(questions)
        for why, more in {**home.left_out, "all worth going to the same": count}.items():
            left_out[why] = left_out.get(why, 0) + more
    if not found:
        raise RfNavError(f"{folder}: no questions of side {side}; make them: hil-sim questions")
    if len(detectors) > 1:
        raise RfNavError(f"{folder}: homes were seen by different detectors; make a new bank")
    return Bank(tuple(found), left_out)


def questions_of(home: BankHome) -> Iterator[BenchQuestion]:
    """One for each moment and goal, unless the frontiers that are worth going to cost the same."""
    for moment in home.moments:
        told = {f.id for f in moment.briefs[CLEAN].frontiers}
        for goal, costs_m in sorted(moment.costs_m.items()):
            costs = zip(moment.ids, costs_m, strict=True)
            question = BenchQuestion(moment, goal, {id: cost for id, cost in costs if id in told})
            if max(question.regrets_m.values()) >= EQUAL_M:
                yield question


def write_home(path: Path, home: BankHome) -> None:
    """Whole or not at all; equal homes give equal bytes."""
    head = {"format": FORMAT, "home": home.name, "left_out": home.left_out, "eyes": home.detector}
    looks = _Looks()
    rows = [_row(moment, looks) for moment in home.moments]
    rows = [head, looks.packed, *rows]
    text = "".join(json.dumps(row, separators=(",", ":")) + "\n" for row in rows)
    draft = path.with_name(f".{os.getpid()}-{path.name}")
    with draft.open("wb") as file, gzip.GzipFile("", "wb", 6, file, mtime=0) as packed:
        packed.write(text.encode())
    draft.replace(path)


def read_home(path: Path) -> BankHome:
    """RfNavError when it is not such a file."""
    try:
        with gzip.open(path, "rt", encoding="utf-8") as file:
            head, *rows = [json.loads(line) for line in file]
        if head["format"] != FORMAT:
            raise RfNavError(f"{path}: format is {head['format']!r}; this version reads {FORMAT!r}")
        looks = {name: _look(told) for name, told in rows[0].items()}
        moments = tuple(_moment(head["home"], row, looks) for row in rows[1:])
        return BankHome(head["home"], moments, head["left_out"], head["eyes"])
    except (OSError, EOFError, ValueError, KeyError, TypeError) as error:
        raise RfNavError(f"{path}: not a home's questions ({error}); remove it") from error


@dataclass
class _Looks:
    """What keyframes showed, packed, by what it is called in the file."""

    packed: dict[str, Any] = field(default_factory=dict)
    names: dict[bytes, str] = field(default_factory=dict)

    def told(self, sight: Sight | None) -> dict[str, object] | None:
        if sight is None:
            return None
        raw = sight.features.tobytes() + sight.depth.tobytes()
        name = self.names.setdefault(hashlib.blake2b(raw).digest(), str(len(self.names)))
        if name not in self.packed:
            both = np.concatenate((sight.features, sight.depth))
            self.packed[name] = {"shape": both.shape, "values": _packed(both)}
        return {"look": name, "column": sight.column, "range_m": sight.range_m}


def _look(told: Mapping[str, Any]) -> F16:
    """(C + 2, h, w) features and depth."""
    return np.frombuffer(base64.b64decode(told["values"]), "<f2").reshape(told["shape"])


def _sight(told: Mapping[str, Any] | None, looks: Mapping[str, F16]) -> Sight | None:
    if told is None:
        return None
    both = looks[told["look"]]
    return Sight(both[:-2], both[-2:], float(told["column"]), float(told["range_m"]))


def _row(moment: Moment, looks: _Looks) -> dict[str, Any]:
    briefs = dict(moment.briefs)
    clean = briefs.pop(CLEAN)
    bare = (replace(f, sight=None) for f in clean.frontiers)
    return {
        "drive": moment.drive,
        "step": moment.step,
        "why": moment.why,
        "order": moment.order,
        "ids": moment.ids,
        "goal_xy": moment.goal_xy,
        "brief": _CONVERTER.unstructure(replace(clean, frontiers=tuple(bare))),
        "sights": [looks.told(f.sight) for f in clean.frontiers],
        "objects": {  # what a perturbed brief has different
            name: [[vars(o) for o in f.objects] for f in brief.frontiers]
            for name, brief in sorted(briefs.items())
        },
        "costs_m": dict(sorted(moment.costs_m.items())),
    }


def _moment(home: str, row: Mapping[str, Any], looks: Mapping[str, F16]) -> Moment:
    clean = _CONVERTER.structure(row["brief"], Brief)
    sights = [_sight(told, looks) for told in row["sights"]]
    seen = (replace(f, sight=s) for f, s in zip(clean.frontiers, sights, strict=True))
    clean = replace(clean, frontiers=tuple(seen))
    briefs = {CLEAN: clean}
    for name, told in row["objects"].items():
        changed = (_with(f, rows) for f, rows in zip(clean.frontiers, told, strict=True))
        briefs[name] = replace(clean, frontiers=tuple(changed))
    costs = {goal: tuple(costs_m) for goal, costs_m in row["costs_m"].items()}
    goal_xy = tuple((float(x), float(y)) for x, y in row["goal_xy"])
    order, ids = tuple(row["order"]), tuple(row["ids"])
    drive, step, why = row["drive"], row["step"], row["why"]
    return Moment(home, drive, step, why, briefs, order, ids, goal_xy, costs)


def _with(frontier: FrontierBrief, objects: Iterable[Mapping[str, Any]]) -> FrontierBrief:
    return replace(frontier, objects=tuple(NearbyObject(**row) for row in objects))


def _is_array(kind: Any) -> bool:
    origin: object = get_origin(kind)
    return origin is np.ndarray


def _packed(array: "np.ndarray[Any, Any]") -> str:
    """Embeddings in half precision."""
    return base64.b64encode(array.astype("<f2").tobytes()).decode()


def _unpacked(text: str, _: object) -> "np.ndarray[Any, Any]":
    return np.frombuffer(base64.b64decode(text), "<f2").astype(np.float32)


_CONVERTER = make_converter()
_CONVERTER.register_unstructure_hook_func(_is_array, _packed)
_CONVERTER.register_structure_hook_func(_is_array, _unpacked)
_BARE = override(omit=True)  # of the drive, not of the question: how frontiers lie to one another
_CONVERTER.register_unstructure_hook(
    Brief, make_dict_unstructure_fn(Brief, _CONVERTER, ahead=_BARE)
)
_CONVERTER.register_structure_hook(Brief, make_dict_structure_fn(Brief, _CONVERTER, ahead=_BARE))
