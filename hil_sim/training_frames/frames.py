"""Labelled frames of generated homes and RoboTHOR replicas, to train and test detectors on.

One process renders one home. Finished homes are kept as shards, so that an interrupted run goes on
where it stopped.
"""

import json
import math
import multiprocessing
import os
import random
from collections import Counter
from concurrent.futures import ProcessPoolExecutor, as_completed
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray
from tqdm import tqdm

from hil_sim.ground_truth.labels import LABELLED, CameraView, labels, seen_room
from hil_sim.scenes.furniture.boxes import box_of
from hil_sim.scenes.generated.home import CLUTTERED, VARIED
from hil_sim.scenes.open import is_replica, open_scene
from hil_sim.scenes.robothor.metadata import APARTMENTS
from hil_sim.scenes.viewpoints import viewpoints
from hil_sim.simulation.camera import Appearance, CameraModel, Light
from hil_sim.simulation.quiet import hushed, keep_stdout_for_python
from hil_sim.training_frames.patterns import patterned

FRAMES_A_HOME = 25
HEIGHT_M = (0.73, 1.03)
PITCH_RAD = math.radians(10)
HFOV_RAD = math.radians(79)


def render_home(
    name: str, frames: int, size: tuple[int, int], out: Path, patterns: float = 0.0
) -> int:
    """Render one home into out/images and write its shard; returns the number of frames. In each a
    share of the things, `patterns`, is made of another stuff. A replica's views get no room type,
    those of its rooms are only inferred from the furniture; nor do those of cluttered and varied
    homes, whose furniture says little of it."""
    keep_stdout_for_python()
    with hushed():
        from hil_sim.scenes.furniture.assets import Assets
        from hil_sim.simulation.scene_physics import ScenePhysics

    cv2.setNumThreads(1)
    scene, rng = open_scene(name), random.Random(f"frames/{name}")
    boxes, rows = [box_of(obj) for obj in scene.objects], []
    plain = not is_replica(name) and not name.endswith((CLUTTERED, VARIED))
    with ScenePhysics(scene, Assets(), "auto", Appearance()) as world:
        for index, (x, y, yaw) in enumerate(viewpoints(rng, scene, frames)):
            pitch = rng.uniform(-PITCH_RAD, PITCH_RAD)
            view = CameraView(x, y, rng.uniform(*HEIGHT_M), yaw, -pitch, HFOV_RAD)
            camera = CameraModel(*size, HFOV_RAD, view.z_m)
            frame = world.render(x, y, yaw, camera, pitch, Light(*daylight(rng)))
            image = f"{name}-{index:02d}.jpg"
            stuff = random.Random(f"stuff/{image}")
            made = patterned(stuff, frame.rgb, frame.segmentation, patterns)
            rgb = photograph(rng, made)
            cv2.imwrite(str(out / "images" / image), rgb[..., ::-1], [cv2.IMWRITE_JPEG_QUALITY, 92])
            found = labels(scene, boxes, view, frame.depth_m, frame.segmentation)
            room = seen_room(scene, view, frame.depth_m) if plain else ""
            objects = [vars(label) for label in found]
            rows.append({"file_name": image, "room": room, "objects": objects})
    shard = _shard(out, name)
    partial = shard.with_suffix(".part")
    partial.write_text(json.dumps(rows), encoding="utf-8")
    os.replace(partial, shard)
    return len(rows)


Triple = tuple[float, float, float]


def daylight(rng: random.Random) -> tuple[Triple, Triple, float, float]:
    """Direction towards the light, its colour, the ambient and the diffuse share."""
    # A nearer light casts shadows with hard edges; a far one shades only.
    reach = 1.0 if rng.random() < 0.3 else 10.0
    azimuth = rng.uniform(-math.pi, math.pi) if reach > 1 else rng.gauss(-0.95, 0.1)
    height = rng.uniform(0.6, 2.0) if reach > 1 else 1.4
    direction = (reach * math.cos(azimuth), reach * math.sin(azimuth), reach * height)
    warm = rng.uniform(-0.05, 0.12)
    colour = (min(1.0, 1.0 + warm), 0.98, min(1.0, 0.98 - warm))
    return direction, colour, rng.uniform(0.4, 0.7), rng.uniform(0.25, 0.6)


def photograph(rng: random.Random, rgb: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """(H, W, 3) RGB with a camera's exposure, white balance, softness and noise."""
    gain = rng.uniform(0.8, 1.3) * np.array([rng.gauss(1, 0.05), 1.0, rng.gauss(1, 0.05)])
    picture = np.asarray(255.0 * (rgb / 255.0) ** rng.uniform(0.8, 1.25) * gain)
    if rng.random() < 0.3:
        picture = np.asarray(cv2.GaussianBlur(picture, (0, 0), rng.uniform(0.4, 1.0)))
    sigma = rng.uniform(0.0, 5.0)
    noise = np.random.default_rng(rng.getrandbits(32)).normal(0.0, sigma, rgb.shape)
    return np.clip(picture + noise, 0, 255).astype(np.uint8)


def homes(
    split: str, seed: int, frames: int, replicas: bool, cluttered: int = 0, varied: int = 0
) -> list[str]:
    """Names of as many homes as `frames` need: the split's RoboTHOR replicas first where they are
    asked for, then generated homes of seeds from `seed` on; and as many cluttered and varied ones
    as `cluttered` and `varied` frames need, of the same seeds."""
    first = f"FloorPlan_{split.capitalize()}"
    found = [name for name in APARTMENTS if replicas and name.startswith(first)]
    count = math.ceil(frames / FRAMES_A_HOME)
    plain = [*found, *(f"{split}-{seed + i}" for i in range(count - len(found)))][:count]
    for kind, more in ((CLUTTERED, cluttered), (VARIED, varied)):
        plain += [f"{split}-{seed + i}-{kind}" for i in range(math.ceil(more / FRAMES_A_HOME))]
    return plain


def render(
    out: Path, frames: int, names: list[str], size: tuple[int, int], workers: int = 2,
    patterns: float = 0.0,
) -> dict[str, Any]:  # fmt: skip
    """Render these homes until there are `frames`; returns the COCO data."""
    for folder in ("images", "shards"):
        (out / folder).mkdir(parents=True, exist_ok=True)
    todo = [name for name in names if not _shard(out, name).exists()]
    done = (len(names) - len(todo)) * FRAMES_A_HOME
    spawn = multiprocessing.get_context("spawn")
    with (
        tqdm(total=frames, initial=min(done, frames), unit="frame", disable=None) as bar,
        ProcessPoolExecutor(workers, mp_context=spawn, max_tasks_per_child=1) as pool,
    ):
        jobs = [pool.submit(render_home, name, FRAMES_A_HOME, size, out, patterns) for name in todo]
        try:
            for job in as_completed(jobs):
                bar.update(min(job.result(), frames - bar.n))
        except BaseException:
            pool.shutdown(cancel_futures=True)
            raise
    coco = collect(out, names, frames, size)
    (out / "annotations.json").write_text(json.dumps(coco), encoding="utf-8")
    return coco


def _shard(out: Path, name: str) -> Path:
    return out / "shards" / f"{name}.json"


def collect(out: Path, names: list[str], frames: int, size: tuple[int, int]) -> dict[str, Any]:
    """The shards of these homes as one COCO detection file."""
    ids = {name: i + 1 for i, name in enumerate(LABELLED)}
    rows = [row for name in names for row in json.loads(_shard(out, name).read_text())]
    images: list[dict[str, Any]] = []
    annotations: list[dict[str, Any]] = []
    for image_id, row in enumerate(rows[:frames], 1):
        images.append(
            {
                "id": image_id,
                "file_name": row["file_name"],
                "width": size[0],
                "height": size[1],
                "room": row["room"],
            }
        )
        for label in row["objects"]:
            annotations.append(
                {
                    "id": len(annotations) + 1,
                    "image_id": image_id,
                    "category_id": ids[label["category"]],
                    "bbox": label["bbox"],
                    "area": label["area"],
                    "iscrowd": int(label["ignore"]),
                }
            )
    categories = [{"id": i, "name": name} for name, i in ids.items()]
    return {"images": images, "annotations": annotations, "categories": categories}


def counts(coco: dict[str, Any]) -> dict[str, int]:
    """Boxes (not ignored) by category."""
    names = {row["id"]: row["name"] for row in coco["categories"]}
    found = Counter(names[a["category_id"]] for a in coco["annotations"] if not a["iscrowd"])
    return {name: found.get(name, 0) for name in names.values()}
