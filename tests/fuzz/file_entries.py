"""Files that somebody else made."""

import io
import json
import shutil
import sqlite3
import struct
import zipfile
from collections.abc import Callable
from contextlib import redirect_stderr
from pathlib import Path
from types import SimpleNamespace
from typing import cast

import numpy as np
from answers import REFUSALS, filed, refused, refused_in_a_line, scratch
from drawn import CUBE, MTL, ROOMS, WALLS, door, piece, save, xml
from places import ROOT

from hil_sim.scenes.format import SceneError
from hil_sim.scenes.scene_file import load_scene
from hil_sim.scenes.sweethome.importer import import_home
from models.errors import ModelFileError
from models.language.gguf_file import refuse_damaged
from models.onnx_file import refuse_external_data
from models.store.manifest import load_manifest
from models.words.row_file import RowFile
from models.words.vocabulary import load_vocabulary
from runtime.config import load
from runtime.core.motion.stops import stop_in_full
from runtime.core.types import (
    Absence,
    Ballot,
    Brief,
    Frontier,
    FrontierBrief,
    Missing,
    NearbyObject,
    Vote,
)
from runtime.core.voting.consensus import ConsensusConfig, elect
from runtime.core.voting.in_full import in_full
from runtime.core.voting.likelihood_experts import LikelihoodQuestion
from runtime.core.world import World
from runtime.errors import RecordingError, RfNavError
from runtime.experts.score_cache import ScoreFile
from runtime.experts.spending import CapReached, Caps, Spending, SpendingError
from runtime.journal import Journal
from runtime.loops.reports import explain
from runtime.recording.reader import Recording
from runtime.replay.script import Script
from runtime.service.goal_queue import read_goals
from runtime.service.told_journal import told_decisions, told_stops
from runtime.service.zones import Surroundings, Zones


def configuration(data: bytes) -> None:
    with refused_in_a_line(RfNavError), redirect_stderr(io.StringIO()):
        load(filed(data, "robot.toml"))


def scene(data: bytes) -> None:
    with refused_in_a_line(SceneError):
        load_scene(filed(data, "home.json"))


def manifest(data: bytes) -> None:
    with refused_in_a_line(ModelFileError):
        load_manifest(filed(data, "models.toml"))


def vocabulary(data: bytes) -> None:
    with refused_in_a_line(ModelFileError):
        load_vocabulary(filed(data, "words.toml"))


def onnx_head(data: bytes) -> None:
    with refused_in_a_line(ModelFileError):
        refuse_external_data(filed(data, "model.onnx"))


def gguf_head(data: bytes) -> None:
    with refused_in_a_line(ModelFileError):
        refuse_damaged(filed(data, "model.gguf"))


def recording(data: bytes) -> None:
    path = filed(data, "drive.mcap")
    with refused_in_a_line(RecordingError):
        for message in Recording(path):
            assert isinstance(message.payload, bytes)
    with refused_in_a_line(RfNavError):
        script = Script.open(path)
        script.config()
        for _ in script.turns():
            pass


def journal(data: bytes) -> None:
    path = filed(data, "decisions.jsonl")
    with refused_in_a_line(RecordingError):
        for told in told_decisions(path):
            assert all(line.isprintable() for line in in_full(told))
    with refused_in_a_line(RecordingError):
        for stop in told_stops(path):
            assert stop_in_full(stop, None)


def goals(data: bytes) -> None:
    """What a process before has left of its goals; see `GoalFile.kept`."""
    with refused_in_a_line(ValueError):
        read_goals(data)


def drawing(data: bytes) -> None:
    out = scratch() / "out"
    try:
        with refused_in_a_line(SceneError):
            import_home(filed(data, "home.sh3d"), out)
    finally:
        shutil.rmtree(out, ignore_errors=True)


def drawing_xml(data: bytes) -> None:
    """The drawing itself, in a sound zip."""
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w") as made:
        made.writestr("Home.xml", data)
        made.writestr("1/cube.obj", CUBE)
        made.writestr("1/cube.mtl", MTL)
    drawing(file.getvalue())


def scores(data: bytes) -> None:
    path = _database(data, "scores.sqlite")
    file = ScoreFile(path, "model")
    found = file.load()
    assert all(isinstance(value, float) for value in found.values())
    file.keep([(LikelihoodQuestion("a bed", " toilet"), -1.5)])
    assert "\n" not in file.error
    REFUSALS.extend([file.error] * bool(file.error))


def spending(data: bytes) -> None:
    path = _database(data, "spending.sqlite")
    with refused_in_a_line(SpendingError, CapReached):
        ledger = Spending(path, Caps(1.0, 1.0))
        ledger.begin("bed")
        ledger.settle(ledger.reserve(1000, "a call"), 500)
        ledger.spent()
        ledger.finish()


def _database(data: bytes, name: str) -> Path:
    for beside in ("-wal", "-shm", "-journal"):
        (scratch() / f"{name}{beside}").unlink(missing_ok=True)
    return filed(data, name)


def embeddings(data: bytes) -> None:
    model = scratch() / "model.bin"
    if not model.exists():
        model.write_bytes(b"model")
    file = RowFile(filed(data, "embeddings.npz"), model)
    rows = file.load()
    REFUSALS.extend([file.error] * bool(file.error))
    for text, row in rows.items():
        assert isinstance(text, str)
        assert row.shape[0] == 1


# -- good inputs ---------------------------------------------------------------------------------


def database_of(write: Callable[[Path], None]) -> bytes:
    path = scratch() / "seed.sqlite"
    path.unlink(missing_ok=True)
    write(path)
    with sqlite3.connect(path) as file:
        file.execute("PRAGMA wal_checkpoint(TRUNCATE)")
    file.close()
    return path.read_bytes()


def some_scores(path: Path) -> None:
    file = ScoreFile(path, "model")
    file.load()
    file.keep([(LikelihoodQuestion(f"a {n}", " toilet"), -float(n)) for n in range(5)])


def some_spending(path: Path) -> None:
    ledger = Spending(path, Caps(1.0, 1.0))
    ledger.begin("bed")
    ledger.settle(ledger.reserve(1000, "a call"), 500)


def some_embeddings() -> bytes:
    path, model = scratch() / "seed.npz", scratch() / "model.bin"
    model.write_bytes(b"model")
    RowFile(path, model).keep({"bed": np.ones((1, 4), np.float32)})
    return path.read_bytes()


def a_journal() -> bytes:
    path = scratch() / "seed.jsonl"
    path.unlink(missing_ok=True)
    sink = (NearbyObject("sink", 0.8, 0.6),)
    brief = Brief("bed", 0, (FrontierBrief(3, 1.0, sink, (("kitchen", 0.7),)),))
    vote = Vote("o2f", (3,), ((3, 0.9),), "3: sink", reasons=((3, "sink"),))
    ballot = Ballot((vote,), (Missing("sle", Absence.LATE),), {"o2f": 0.25})
    frontiers = (Frontier(3, np.zeros((1, 2)), (1.0, 0.5), 1.0),)
    world = SimpleNamespace(body=SimpleNamespace(step=9), frontiers=frontiers)
    decision = elect(ballot, brief.frontiers, ConsensusConfig(mode="lenient"))
    with Journal(path) as file:
        file.write("goal", text="bed")
        file.write("standing", at_s=1.0, was="searching", now="held: frame: none")
        file.write("decision", brief=brief, **explain(decision, cast(World, world), "nearest"))
        file.write("standing", at_s=3.0, was="held: frame: none", now="searching")
    return path.read_bytes()


def some_goals() -> bytes:
    kept = [{"id": "a1", "text": "bed", "body": {"goal": "bed"}, "paused": False, "begun": 1}]
    return json.dumps({"version": 1, "goals": kept}).encode()


def a_drawing() -> bytes:
    home = xml(WALLS, ROOMS, door(400, 200), piece("Bed", 600, 200, model="1/cube.obj"))
    return save(scratch() / "seed.sh3d", home, {"1/cube.obj": CUBE.encode()}).read_bytes()


def a_gguf() -> bytes:
    def text(value: bytes) -> bytes:
        return struct.pack("<Q", len(value)) + value

    keys = text(b"general.alignment") + struct.pack("<II", 4, 32)
    keys += text(b"general.name") + struct.pack("<I", 8) + text(b"small")
    keys += text(b"tokens") + struct.pack("<IIQ", 9, 8, 2) + text(b"a") + text(b"bc")
    keys += text(b"scores") + struct.pack("<IIQff", 9, 6, 2, 0.5, 1.0)
    tensor = text(b"blk.0") + struct.pack("<IQQIQ", 2, 4, 4, 0, 0)
    head = b"GGUF" + struct.pack("<IQQ", 3, 1, 4) + keys + tensor
    return head.ljust(-(-len(head) // 32) * 32, b"\0") + bytes(64)


def an_onnx() -> bytes:
    from onnx import TensorProto, helper

    value = helper.make_tensor_value_info("x", TensorProto.FLOAT, [1, 3])
    weights = helper.make_tensor("w", TensorProto.FLOAT, [3], [0.5, 1.0, 2.0])
    nodes = [helper.make_node("Add", ["x", "w"], ["y"], "add")]
    graph = helper.make_graph(nodes, "g", [value], [value], [weights])
    return bytes(helper.make_model(graph).SerializeToString())


def shortened(path: Path) -> bytes:
    """The first few kilobytes of a recording: whole chunks, and one that is cut."""
    return path.read_bytes()[:60_000]


TEXTS = (
    (ROOT / "deploy" / "robot.toml").read_bytes(),
    b'[map]\nmax_depth_m = 3\n[panel]\nexperts = ["o2f"]\n',
)
MODELS = b"""["a"]
task = "detector"
licence = "MIT"
[["a".files]]
name = "a.onnx"
bytes = 12
sha256 = "00"
sources = [{ url = "https://example.com/a.onnx" }]
"""
WORDS = b'objects = [["bed"], ["sofa", "couch"]]\nrooms = ["kitchen"]\n[also]\nbed = ["bunk"]\n'


def some_zones() -> bytes:
    path = scratch() / "seed.json"
    path.unlink(missing_ok=True)
    square = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]]
    assert Zones(path, NOWHERE).answer({"add": "stairs", "polygon": square})["accepted"]
    return path.read_bytes()


def zones(data: bytes) -> None:
    """A file of zones: bad ones are put aside, and no goal is taken."""
    folder = scratch() / "zones"
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir()
    path = folder / "zones.json"
    path.write_bytes(data)
    some = Zones(path, NOWHERE)
    if "draw the keep-out zones again" in some.unbound():
        refused(some.unbound())
    assert path.exists() or any(folder.iterdir())
    assert some.now() == ()


NOWHERE = Surroundings(lambda: None, lambda: (0.0, 0.0))
