"""Labelled frames to judge on, and the groups of categories that numbers are given for."""

import json
import tomllib
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray
from tqdm import tqdm

from models.errors import ModelFileError

NAMES = Path(__file__).parent.parent / "train" / "names.toml"
ASKED = Path(__file__).parent / "asked.toml"
HM3D = ("chair", "sofa", "plant", "bed", "toilet", "television")
ROBOTHOR = (
    "alarm clock", "apple", "baseball bat", "basketball", "bowl", "trash can", "plant", "laptop",
    "mug", "spray bottle", "television", "vase",
)  # fmt: skip
HOUSEHOLD = (
    "chair", "sofa", "plant", "bed", "table", "toilet", "television", "laptop", "microwave",
    "stove", "sink", "refrigerator", "book", "clock", "vase", "bottle", "cup", "bowl",
)  # fmt: skip
"""What both photographs with a list of COCO's and our renderings show."""
GOALS = tuple(dict.fromkeys(HM3D + ROBOTHOR))


@dataclass(frozen=True)
class Marks:
    """One frame's truth: `boxes` (M, 4) px corners, `kinds` (M,) index into the categories,
    `crowd` (M,) what is too small or too hidden to be asked for."""

    boxes: NDArray[np.float32]
    kinds: NDArray[np.int64]
    crowd: NDArray[np.bool_]


@dataclass(frozen=True)
class FrameTruth:
    """A directory of frames as `hil-sim frames` writes it; `table` is its COCO table."""

    directory: Path
    table: dict[str, Any]
    categories: tuple[str, ...]
    marks: tuple[Marks, ...]

    def pictures(self, what: str = "frames") -> Iterator[NDArray[np.uint8]]:
        """Every frame, (H, W, 3) RGB, in the table's order."""
        for image in tqdm(self.table["images"], desc=what, disable=None):
            yield self.picture(image["file_name"])

    def picture(self, name: str) -> NDArray[np.uint8]:
        """One frame, (H, W, 3) RGB."""
        for folder in (self.directory / "images", self.directory):
            bgr = cv2.imread(str(folder / name)) if (folder / name).is_file() else None
            if bgr is not None:
                return np.asarray(cv2.cvtColor(bgr, cv2.COLOR_BGR2RGB), np.uint8)
        raise ModelFileError(
            f"{self.directory}: image {name} cannot be read; render the frames again"
        )


@dataclass(frozen=True)
class NameLists:
    """What training called things: `trained` categories with all their names, `held_out` ones, the
    `unseen` synonyms and the `near` categories of each trained one, and the room types; and what
    else people may have `asked` for a category by."""

    trained: dict[str, tuple[str, ...]]
    held_out: tuple[str, ...]
    unseen: dict[str, tuple[str, ...]]
    near: dict[str, tuple[str, ...]]
    rooms: tuple[str, ...]
    asked: dict[str, tuple[str, ...]]


def read_truth(directory: Path, limit: int | None = None) -> FrameTruth:
    """The annotations of a directory of frames, or of its first `limit`. Where `info.labelled` says
    which categories are boxed throughout, others are left out. Raises ModelFileError."""
    path = directory / "annotations.json"
    try:
        table: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
        images = table["images"][:limit]
        kept = {image["id"] for image in images}
        labelled = table.get("info", {}).get("labelled")
        known = [c for c in table["categories"] if labelled is None or c["name"] in labelled]
        ids = {c["id"] for c in known}
        notes = [
            m for m in table["annotations"] if m["image_id"] in kept and m["category_id"] in ids
        ]
        categories = tuple(c["name"] for c in known)
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise ModelFileError(
            f"{path}: not a readable COCO table ({error}); make it with `hil-sim frames`"
        ) from error
    table = {"images": images, "annotations": notes, "categories": known}
    if not images:
        raise ModelFileError(f"{path}: holds no frames; make some with `hil-sim frames`")
    return FrameTruth(directory, table, categories, _marks(table))


def _marks(table: dict[str, Any]) -> tuple[Marks, ...]:
    index = {c["id"]: k for k, c in enumerate(table["categories"])}
    by_image: dict[int, list[dict[str, Any]]] = {image["id"]: [] for image in table["images"]}
    for note in table["annotations"]:
        by_image[note["image_id"]].append(note)
    found = []
    for notes in by_image.values():
        boxes = np.array([n["bbox"] for n in notes], np.float32).reshape(-1, 4)
        boxes[:, 2:] += boxes[:, :2]
        kinds = np.array([index[n["category_id"]] for n in notes], np.int64)
        found.append(Marks(boxes, kinds, np.array([bool(n.get("iscrowd")) for n in notes], bool)))
    return tuple(found)


def read_words(path: Path = NAMES) -> NameLists:
    """The names that training used, and those it did not."""
    table = tomllib.loads(path.read_text(encoding="utf-8"))
    known: dict[str, Any] = table["categories"]
    asked: dict[str, list[str]] = tomllib.loads(ASKED.read_text(encoding="utf-8"))
    return NameLists(
        trained={name: tuple(body["names"]) for name, body in known.items()},
        held_out=tuple(table.get("held_out", ())),
        unseen={name: tuple(body.get("unseen", ())) for name, body in known.items()},
        near={name: tuple(body.get("near", ())) for name, body in known.items()},
        rooms=tuple(table["rooms"]["names"]),
        asked={name: tuple(names) for name, names in asked.items()},
    )
