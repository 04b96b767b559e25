"""What a robot sees toward frontiers, and what truly lies behind them: one file a home, to train
the scene-layout expert on and to judge it by.

Frames are the keyframes of one drive that the robot had kept when it was asked, rows are views: of
one frontier at one moment, by one of the keyframes that show it. See `HomeViews`.
"""

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from hil_sim.driving.rig import camera_of, open_world
from hil_sim.expert_bench.bank import BankPlan
from hil_sim.expert_bench.drive import ORIGIN, Stop, stops
from hil_sim.expert_bench.seeing import BenchDetector
from hil_sim.ground_truth.labels import LABELLED, LEAST_PIXELS, CameraView, seen_room
from hil_sim.ground_truth.lies_beyond import LiesBeyond
from hil_sim.ground_truth.true_labels import pixels
from hil_sim.ground_truth.witness import to_scene
from hil_sim.scenes.format import ROOM_TYPES, Scene
from hil_sim.scenes.furniture.assets import Assets
from hil_sim.scenes.open import open_scene
from hil_sim.simulation.camera import Frame
from hil_sim.simulation.protocol import HM3D
from runtime.core.mapping.keyframes import best_frames
from runtime.core.mapping.sights import sight_depth, way_of
from runtime.core.types import Detections, FrontierBrief, Observation, Pose
from runtime.core.world import World
from runtime.errors import RfNavError

if TYPE_CHECKING:  # PyBullet prints when it is imported: see open_world
    from hil_sim.ground_truth.freespace import FreeSpace

FORMAT = 2
VIEWS = 3
"""Keyframes of one frontier at one moment at most, the runtime's choice first."""
PLAN = BankPlan(starts=1, steps=120, moments=18, apart=4, goals=0, wander=0.7)
Array = NDArray[Any]


@dataclass(frozen=True)
class HomeViews:
    """F frames, N rows, categories C (LABELLED), room types R (ROOM_TYPES), in these orders.

    Frames: `features` (F, D, h, w), `depth` (F, 2, h, w), `scene` (F, 384), `rooms` (F, R) the
    detector's word; in truth the room that is in view, `room` (F,), -1 none or several, and which
    categories are, `in_view` (F, C).
    Rows: `frame` (N,); `column` 0..1 and `range_m` of the frontier in it; `moment`, `frontier`;
    `best`: the runtime's choice of frame; of the brief `distance_m`, `unknown_m2`, `told_rooms`
    (N, R). In truth: `asked` (N, C) categories of the home that were never in view so far, `absent`
    (N, C) those that it lacks; metres of walking from the frontier to the nearest that was never in
    view, inf where there is none, `beyond_m` (N, C) through what the map does not know,
    `onward_m` (N, C) by any way; floor `area_m2` behind it and of that by room type, `room_m2`
    (N, R): hil_sim/ground_truth/lies_beyond.py.
    `detector`: SHA-256 of the file whose features, embeddings and rooms they are.
    """

    features: Array
    depth: Array
    scene: Array
    rooms: Array
    room: Array
    in_view: Array
    frame: Array
    column: Array
    range_m: Array
    moment: Array
    frontier: Array
    best: Array
    distance_m: Array
    unknown_m2: Array
    told_rooms: Array
    asked: Array
    absent: Array
    beyond_m: Array
    onward_m: Array
    area_m2: Array
    room_m2: Array
    detector: str


KINDS = {
    "features": np.float16, "depth": np.float16, "scene": np.float16, "rooms": np.float16,
    "room": np.int8, "in_view": np.bool_, "frame": np.int32, "column": np.float32,
    "range_m": np.float32, "moment": np.int32, "frontier": np.int32, "best": np.bool_,
    "distance_m": np.float32, "unknown_m2": np.float32, "told_rooms": np.float16,
    "asked": np.bool_, "absent": np.bool_, "beyond_m": np.float32, "onward_m": np.float32,
    "area_m2": np.float32, "room_m2": np.float32,
}  # fmt: skip
OF_FRAMES = ("features", "depth", "scene", "rooms", "room", "in_view")


@dataclass(frozen=True)
class _Seen:
    """A frame of the drive, its pose on the map, what is seen in it and what is true of it."""

    obs: Observation
    values: dict[str, Any]

    def again(self, detector: BenchDetector) -> "_Seen":
        """The same frame as another detector sees it."""
        said = _said(self.obs, detector.models.detect(self.obs.rgb))
        return replace(self, values=self.values | said)


@dataclass
class _Watcher:
    """Keeps what every frame of a drive shows."""

    scene: Scene
    frames: list[_Seen] = field(default_factory=list)
    unseen: NDArray[np.bool_] = field(default_factory=lambda: np.zeros(0, bool))

    def __post_init__(self) -> None:
        self.unseen = np.ones(len(self.scene.objects), bool)

    def watch(self, obs: Observation, seen: Detections, at: Pose, frame: Frame) -> None:
        shown = pixels(frame.segmentation, len(self.scene.objects)) >= LEAST_PIXELS
        self.unseen &= ~shown
        camera = camera_of(HM3D)
        view = CameraView(at.x_m, at.y_m, camera.z_m, at.yaw_rad, 0.0, camera.hfov_rad)
        room = seen_room(self.scene, view, frame.depth_m)
        here = {self.scene.objects[n].category for n in np.flatnonzero(shown)}
        self.frames.append(_Seen(obs, _said(obs, seen) | {
            "room": ROOM_TYPES.index(room) if room in ROOM_TYPES else -1,
            "in_view": [name in here for name in LABELLED],
        }))  # fmt: skip


def _said(obs: Observation, seen: Detections) -> dict[str, Any]:
    """What a detector says of a whole frame, and how far the parts are that it tells of."""
    return {
        "features": seen.features,
        "depth": sight_depth(obs.depth_m, *seen.features.shape[1:]),
        "scene": seen.scene,
        "rooms": seen.rooms,
    }


def views_of(
    name: str, detector: BenchDetector, plan: BankPlan = PLAN, others: Sequence[BenchDetector] = ()
) -> list[HomeViews]:
    """Drive through a home by one detector's word, and keep what is seen toward frontiers: as it
    sees it, then as each of the others sees the same frames (`told_rooms` stay the first one's).
    SceneError when the home cannot be opened."""
    scene, assets = open_scene(name), Assets()
    with open_world(scene, assets, "auto") as world:
        from hil_sim.ground_truth.truth import SceneTruth

        space = SceneTruth(world, assets).space
        there, rows = LiesBeyond.of(space), list[dict[str, object]]()
        frames = list[_Seen]()
        for number in range(plan.starts):
            watcher = _Watcher(scene)
            drive = stops(name, number, world, space, detector, plan, watcher.watch)
            for moment, stop in enumerate(drive):
                rows += _rows(stop, number * plan.moments + moment, there, watcher, len(frames),
                              detector)  # fmt: skip
            frames += watcher.frames
        return _packed(frames, rows, (detector, *others))


def _rows(
    stop: Stop, moment: int, there: LiesBeyond, watcher: _Watcher, before: int,
    detector: BenchDetector,
) -> list[dict[str, object]]:  # fmt: skip
    """Views of the frontiers at one moment; frames are counted from `before` on."""
    known = stop.known
    assert known.lens is not None  # since the first frame
    intrinsics, mount = known.lens
    brief = stop.told(detector.config.navigate)
    cells = {f.id: f.cells_xy for f in stop.reachable}
    kept, poses = _kept(known, watcher)
    move, unknown = to_scene(stop.start, ORIGIN), _unknown(stop, there.space)
    here = {watcher.scene.objects[n].category for n in range(len(watcher.unseen))}
    met = {watcher.scene.objects[n].category for n in np.flatnonzero(~watcher.unseen)}
    rows = list[dict[str, object]]()
    for told in brief.frontiers:
        chosen = best_frames(poses, cells[told.id], known.map, VIEWS)
        found = [(place, kept[n]) for place, n in enumerate(chosen) if kept[n] >= 0]
        if not found:
            continue
        in_scene = np.array([move(x, y) for x, y in cells[told.id]])
        truth = there.behind(in_scene, unknown, watcher.unseen)
        common = {
            **vars(truth),
            "moment": moment,
            "frontier": told.id,
            "distance_m": told.distance_m,
            "unknown_m2": told.unknown_m2,
            "told_rooms": _rooms(told),
            "asked": [name in here and name not in met for name in LABELLED],
            "absent": [name not in here for name in LABELLED],
        }
        for place, n in found:
            seen = watcher.frames[n]
            shape = seen.values["features"].shape[1:]
            column, range_m = way_of(cells[told.id], seen.obs.pose, mount, intrinsics, *shape)
            rows.append(common | {"frame": before + n, "best": place == 0, "column": column,
                                  "range_m": range_m})  # fmt: skip
    return rows


def _kept(known: World, watcher: _Watcher) -> tuple[list[int], NDArray[np.float64]]:
    """Of the keyframes that the robot has: which frame of the drive each is, -1 where it tells no
    parts; their poses (N, 3), m, rad."""
    # Equal poses, equal images.
    number = {seen.obs.pose: n for n, seen in enumerate(watcher.frames)}
    frames = [number[f.pose] if f.features.size else -1 for f in known.keyframes]
    poses = [(f.pose.x_m, f.pose.y_m, f.pose.yaw_rad) for f in known.keyframes]
    return frames, np.array(poses).reshape(-1, 3)


def _rooms(told: FrontierBrief) -> list[float]:
    said = dict(told.rooms)
    return [said.get(name, 0.0) for name in ROOM_TYPES]


def _unknown(stop: Stop, space: "FreeSpace") -> NDArray[np.bool_]:
    """(H, W) of the true grid: which cells the robot's map does not know."""
    rows, cols = np.indices(space.free.shape)
    points = space.points(np.stack([rows.ravel(), cols.ravel()], axis=1))
    dx, dy = points[:, 0] - stop.start.x_m, points[:, 1] - stop.start.y_m
    c, s = np.cos(stop.start.yaw_rad), np.sin(stop.start.yaw_rad)
    grid = stop.known.map
    cells = grid.frame.cells(np.column_stack((c * dx + s * dy, -s * dx + c * dy)))
    inside = ((cells >= 0) & (cells < grid.frame.shape)).all(axis=1)
    unknown = np.ones(len(cells), bool)
    unknown[inside] = grid.unknown[tuple(cells[inside].T)]
    return unknown.reshape(space.free.shape)


def _packed(
    frames: Sequence[_Seen], rows: list[dict[str, object]], detectors: Sequence[BenchDetector]
) -> list[HomeViews]:
    """Only frames that a row is of, which the first detector has seen already."""
    used = sorted({int(str(row["frame"])) for row in rows})
    place = {old: new for new, old in enumerate(used)}
    kept = [frames[n] for n in used]
    columns: dict[str, Array] = {
        name: np.array([row[name] for row in rows], kind)
        for name, kind in KINDS.items()
        if name not in OF_FRAMES
    }
    columns["frame"] = np.array([place[n] for n in columns["frame"].tolist()], np.int32)
    seen = [kept, *([frame.again(other) for frame in kept] for other in detectors[1:])]
    return [
        HomeViews(**columns, **_columns(by), detector=detector.sha256())
        for detector, by in zip(detectors, seen, strict=True)
    ]


def _columns(frames: Sequence[_Seen]) -> dict[str, Array]:
    return {name: np.array([f.values[name] for f in frames], KINDS[name]) for name in OF_FRAMES}


def write_views(path: Path, views: HomeViews) -> None:
    """Whole or not at all; what is left of a write that was killed is no `*.npz`."""
    draft = path.with_name(f".{os.getpid()}-{path.name}.part")
    with draft.open("wb") as file:
        np.savez(file, format=FORMAT, categories=np.array(LABELLED),
                 room_names=np.array(ROOM_TYPES), **vars(views))  # fmt: skip
    draft.replace(path)


def read_views(path: Path) -> HomeViews:
    """RfNavError when it is not such a file, or of other categories or room types."""
    try:
        with np.load(path, allow_pickle=False) as kept:
            known = tuple(kept["categories"]), tuple(kept["room_names"])
            if int(kept["format"]) != FORMAT or known != (LABELLED, tuple(ROOM_TYPES)):
                raise RfNavError(f"{path}: made by another version; remove it: hil-sim beyond")
            columns = {name: kept[name] for name in KINDS}
            return HomeViews(**columns, detector=str(kept["detector"]))
    except (OSError, ValueError, KeyError) as error:
        raise RfNavError(f"{path}: not a home's views ({error}); remove it") from error


def make_views(files: Mapping[str, Path], name: str) -> None:
    """One home into a file for each detector, of which the first one's word is driven by.
    RfNavError for one that does not tell features."""
    detectors = [BenchDetector.open(detector) for detector in files]
    for detector, named in zip(detectors, files, strict=True):
        if not detector.sha256():
            raise RfNavError(
                f"{named}: does not tell what its backbone sees; python -m models.train.features "
                "makes a file of it that does"
            )
    views = views_of(name, detectors[0], others=detectors[1:])
    for detector in detectors:
        detector.models.close()
    for path, seen in zip(files.values(), views, strict=True):
        write_views(path, seen)
