"""Making a bank: one process a home, and finished homes are kept."""

import gzip
import os
import pickle
from dataclasses import replace
from functools import partial
from pathlib import Path

from tqdm import tqdm

from hil_sim.expert_bench.bank import HOMES, PLAN_FILE, BankPlan, read_home, write_home
from hil_sim.expert_bench.home_jobs import claim, make_homes, plan_in
from hil_sim.scenes.robothor.metadata import APARTMENTS
from hil_sim.simulation.quiet import keep_stdout_for_python
from runtime.errors import RfNavError

MAPS = "maps"
"""Folder of the maps behind the questions, where they are kept."""
FIRST_SEED = 100_000
"""Of the generated homes: no detector was trained on frames of these."""
REPLICA_EVERY = 3
"""Every so many-th home is a RoboTHOR replica, while there are any."""


def home_names(count: int, seed: int) -> list[str]:
    """Homes of the train split. A longer list begins with the shorter one; layouts of RoboTHOR
    come in turn, so that any part has many."""
    train = [name for name in APARTMENTS if name.startswith("FloorPlan_Train")]
    replicas = sorted(train, key=lambda name: int(name.rpartition("_")[2]))  # first of each layout
    names, at = list[str](), FIRST_SEED * (seed + 1)
    while len(names) < count:
        if len(names) % REPLICA_EVERY == REPLICA_EVERY - 1 and replicas:
            names.append(replicas.pop(0))
        else:
            names.append(f"train-{at}")
            at += 1
    return names


def make_bank(
    folder: Path, names: list[str], plan: BankPlan, workers: int, maps: bool = False
) -> int:
    """Add the homes that are not in the folder yet; returns how many were made. RfNavError when
    the folder was begun with another plan."""
    for part in (HOMES, MAPS):
        (folder / part).mkdir(parents=True, exist_ok=True)
    claim(folder / PLAN_FILE, plan)
    todo = [name for name in names if not home_file(folder, name).exists()]
    make_homes(names, todo, workers, partial(make_home, folder, plan=plan, maps=maps))
    return len(todo)


def make_home(folder: Path, name: str, plan: BankPlan, maps: bool) -> None:
    """A worker's task: one home."""
    keep_stdout_for_python()
    import cv2

    from hil_sim.expert_bench.drive import Stop, drive_home

    cv2.setNumThreads(1)
    kept: list[bytes] = []

    def keep(stop: Stop) -> None:
        kept.append(pickle.dumps(stop))  # now: the drive goes on with the same map

    home = drive_home(name, plan, keep if maps else lambda stop: None)
    if maps:
        write_maps(folder, name, kept)
    write_home(home_file(folder, name), home)


def write_maps(folder: Path, name: str, kept: list[bytes]) -> None:
    """A home's pickled `Stop`s, in the order of its moments."""
    path = folder / MAPS / f"{name}.pickle.gz"
    draft = path.with_name(f".{os.getpid()}-{path.name}")
    with gzip.open(draft, "wb", 3) as file:
        pickle.dump(kept, file)
    draft.replace(path)


def tell_again(folder: Path, plan: BankPlan) -> int:
    """Compose the briefs of all homes whose maps were kept, with the code and settings as they are
    now; returns how many. The maps must have been kept by the same version of the code."""
    from hil_sim.expert_bench.drive import Stop, frozen
    from hil_sim.expert_bench.seeing import BenchDetector

    cfg = BenchDetector.settings().navigate
    files = {p: home_file(folder, p.name.split(".")[0]) for p in (folder / MAPS).glob("*.gz")}
    paths = sorted(path for path, file in files.items() if file.exists())
    for path in tqdm(paths, unit="home", disable=None):
        file = files[path]
        home = read_home(file)
        with gzip.open(path) as packed:
            stops: list[Stop] = [pickle.loads(kept) for kept in pickle.load(packed)]
        moments = tuple(
            frozen(home.name, stop, moment.costs_m, plan, cfg)
            for stop, moment in zip(stops, home.moments, strict=True)
        )
        write_home(file, replace(home, moments=moments))
    return len(paths)


def home_file(folder: Path, name: str) -> Path:
    return folder / HOMES / f"{name}.jsonl.gz"


def plan_of(folder: Path) -> BankPlan:
    """How a bank was made; RfNavError when the folder is none."""
    path = folder / PLAN_FILE
    if not path.is_file():
        raise RfNavError(f"{path}: no such file; make a bank: hil-sim questions")
    return plan_in(path, BankPlan)
