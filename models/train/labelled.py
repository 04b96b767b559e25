"""Labelled frames: those that `hil-sim frames` writes, and photographs in the same form (COCO
detection JSON), of which not everything is boxed; and how much of an epoch each folder is."""

import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import click
import numpy as np
from numpy.typing import NDArray

from models.errors import ModelFileError

SCARCE = 0.03
"""A category that fewer of the frames show than this is shown again (`repeated`)."""
TAUGHT = 0.2
"""How surely a picture has none of a category without a box, where teachers drew them: they miss
more than half."""
UNLEARNED = -1
"""The label of what is of a held-out category, or of none that is trained; it is ignored."""


@dataclass(frozen=True)
class Labelled:
    """One frame: boxes (N, 4) px corners, labels (N,) category indices or UNLEARNED, ignore (N,)
    bool, surety (N,) 0..1, how sure whoever drew the box was; boxed (C,) 0..1, how surely there is
    none of a category without a box."""

    path: Path
    boxes: NDArray[np.float32]
    labels: NDArray[np.int64]
    ignore: NDArray[np.bool_]
    surety: NDArray[np.float32]
    boxed: NDArray[np.float32]
    room: str


class Portion(NamedTuple):
    """Frames; `share` (0..1) of an epoch comes from here, None: every frame, once."""

    path: Path
    share: float | None = None


class PortionParam(click.ParamType[Portion]):
    """DIR or DIR=SHARE on a command line."""

    name = "DIR[=SHARE]"

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> Portion:
        if isinstance(value, Portion):
            return value
        folder, _, share = str(value).partition("=")
        if not Path(folder).is_dir():
            self.fail(f"{folder}: no such folder", param, ctx)
        try:
            part = float(share) if share else None
        except ValueError:
            part = -1.0
        if part is not None and not 0 < part < 1:
            self.fail(f"{value}: the share must be a number between 0 and 1", param, ctx)
        return Portion(Path(folder), part)


def read_frames(
    directory: Path, categories: Sequence[str], held_out: Sequence[str] = ()
) -> list[Labelled]:
    """All finished frames of a directory, labels as indices into `categories`; what is of a
    `held_out` category becomes an ignore region.

    Reads annotations.json where it is there, and the shards of a rendering that still runs. A
    table whose `info.labelled` lists what is boxed throughout, and `info.taught` what teachers
    boxed, may have other categories, too.
    """
    index = {name: i for i, name in enumerate(categories)} | dict.fromkeys(held_out, UNLEARNED)
    frames: dict[Path, Labelled] = {}
    for path in sorted(directory.rglob("*.json")):
        try:
            table = json.loads(path.read_text(encoding="utf-8"))
        except (OSError, ValueError):
            continue  # still being written; the next scan finds it whole
        boxed, known = np.ones(len(categories), np.float32), index
        info = table.get("info", {}) if isinstance(table, dict) else {}
        if "labelled" in info:
            sure = dict.fromkeys(info.get("taught", ()), TAUGHT) | dict.fromkeys(
                info["labelled"], 1
            )
            boxed = np.array([sure.get(name, 0) for name in categories], np.float32)
            known = {c["name"]: UNLEARNED for c in table["categories"]} | index
        for row in _rows(table):
            image = _find(path.parent, row["file_name"])
            if image is not None and image not in frames:
                frames[image] = _labelled(image, row, known, boxed)
    if not frames:
        raise ModelFileError(f"{directory}: no annotated frames; make some with `hil-sim frames`")
    return list(frames.values())


def read_epoch(
    folders: Sequence[Portion], categories: Sequence[str], held_out: Sequence[str],
    rng: np.random.Generator,
) -> list[Labelled]:  # fmt: skip
    """What one epoch shows: of folders without a share every frame, of the others as many as their
    shares ask for, drawn at random; either with those of scarce categories `repeated`."""
    shares = sum(folder.share or 0.0 for folder in folders)
    whole = [folder for folder in folders if folder.share is None]
    if shares >= 1 or not whole:
        raise ModelFileError(
            f"{', '.join(str(f.path) for f in folders)}: the shares must be less than 1 in all, "
            "and one folder have none: all its frames are an epoch's rest"
        )
    shown = [
        frame
        for folder in whole
        for frame in repeated(read_frames(folder.path, categories, held_out), rng)
    ]
    total = len(shown) / (1 - shares)
    for folder in folders:
        if folder.share is not None:
            frames = read_frames(folder.path, categories, held_out)
            shown += _drawn(frames, round(folder.share * total), rng)
    return shown


def _drawn(frames: Sequence[Labelled], count: int, rng: np.random.Generator) -> list[Labelled]:
    found: list[Labelled] = []
    while len(found) < count:
        again = repeated(frames, rng)
        found += [again[i] for i in rng.permutation(len(again))]
    return found[:count]


def repeated(frames: Sequence[Labelled], rng: np.random.Generator) -> list[Labelled]:
    """The frames, those with a scarce category several times over: sqrt(SCARCE / its share of the
    frames) times on average, by the scarcest that a frame shows (Gupta et al. 2019)."""
    shown = [np.unique(frame.labels[~frame.ignore]) for frame in frames]
    found = np.bincount(np.concatenate(shown))
    times = np.sqrt(np.maximum(1.0, SCARCE * len(frames) / np.maximum(found, 1)))
    wanted = np.array([times[labels].max(initial=1.0) for labels in shown])
    counts = np.floor(wanted + rng.random(len(frames))).astype(int)
    return [frame for frame, count in zip(frames, counts, strict=True) for _ in range(count)]


def _rows(table: Any) -> list[dict[str, Any]]:
    """A shard's rows; a COCO table is brought into the same form."""
    if isinstance(table, list):
        return [r for r in table if isinstance(r, dict) and "objects" in r]
    if not isinstance(table, dict) or "images" not in table or "annotations" not in table:
        return []
    names = {c["id"]: c["name"] for c in table["categories"]}
    objects: dict[int, list[dict[str, Any]]] = {}
    for mark in table["annotations"]:
        row = {"category": names[mark["category_id"]], "bbox": mark["bbox"]}
        row |= {"ignore": bool(mark.get("iscrowd")), "score": mark.get("score", 1.0)}
        objects.setdefault(mark["image_id"], []).append(row)
    return [{**image, "objects": objects.get(image["id"], [])} for image in table["images"]]


def _labelled(
    path: Path, row: dict[str, Any], index: dict[str, int], boxed: NDArray[np.float32]
) -> Labelled:
    marks = row["objects"]
    for mark in marks:
        if mark["category"] not in index:
            raise ModelFileError(
                f"{path}: category {mark['category']!r} has no names in names.toml"
            )
    labels = np.array([index[m["category"]] for m in marks], np.int64)
    xywh = np.array([m["bbox"] for m in marks], np.float32).reshape(-1, 4)
    return Labelled(
        path=path,
        boxes=np.concatenate((xywh[:, :2], xywh[:, :2] + xywh[:, 2:]), axis=1),
        labels=labels,
        ignore=np.array([bool(m["ignore"]) for m in marks], np.bool_) | (labels == UNLEARNED),
        surety=np.array([m.get("score", 1.0) for m in marks], np.float32),
        boxed=boxed,
        room=str(row.get("room") or ""),
    )


def _find(root: Path, name: str) -> Path | None:
    for folder in (root / "images", root, root.parent / "images", root.parent):
        if (folder / name).is_file():
            return (folder / name).resolve()
    return None
