"""Where bytes from outside become values: what is fuzzed, by Hypothesis in the tests beside this
file and by atheris in scripts/fuzz. Each entry is given bytes, and may raise nothing."""

import atexit
import io
import json
import shutil
import sqlite3
import struct
import tempfile
import threading
import zipfile
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, redirect_stderr
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np
from drawn import CUBE, MTL, ROOMS, WALLS, door, piece, save, xml
from manual_clock import ManualClock
from other_half import (
    battery_state,
    compressed_color,
    flag,
    hazards,
    laser_scan,
    slam_pose,
    tf,
)
from places import ROOT, TESTS
from rover_bytes import SEEDS, rover_bytes

from hil_sim.scenes.format import SceneError
from hil_sim.scenes.scene_file import load_scene
from hil_sim.scenes.sweethome.importer import import_home
from models.errors import ModelFileError
from models.language.gguf_file import refuse_damaged
from models.onnx_file import refuse_external_data
from models.store.manifest import load_manifest
from models.words.row_file import RowFile
from models.words.vocabulary import load_vocabulary
from runtime.clock import Deadline
from runtime.config import load
from runtime.core.types import Intrinsics, Pose
from runtime.core.voting.likelihood_experts import LikelihoodQuestion
from runtime.errors import RecordingError, RfNavError, SensorError
from runtime.experts.score_cache import ScoreFile
from runtime.experts.spending import CapReached, Caps, Spending, SpendingError
from runtime.loops.goal_request import STRICT, Terms, cancel_reason
from runtime.recording.reader import Recording
from runtime.replay.script import Script
from runtime.robot import wire
from runtime.robot.body_senses import BodySenses
from runtime.robot.requests import WAITING, Requests
from runtime.robot.session import BusConfig, SensesConfig, TopicsConfig
from runtime.robot.streams import SensorStreams
from runtime.robot.transforms import TF, CameraConfig

S = 10**9


@dataclass(frozen=True)
class EntryPoint:
    """`seeds` are good inputs; `run` takes any bytes. `slow`: it opens files, a hundred times as
    long as the others."""

    seeds: Sequence[bytes]
    run: Callable[[bytes], None]
    slow: bool = False


@cache
def scratch() -> Path:
    """A folder in memory, of this process."""
    memory = Path("/dev/shm")
    folder = Path(tempfile.mkdtemp(prefix="rfnav-fuzz-", dir=memory if memory.is_dir() else None))
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    return folder


def filed(data: bytes, name: str) -> Path:
    path = scratch() / name
    path.write_bytes(data)
    return path


REFUSALS: deque[str] = deque(maxlen=1)
"""The newest answer that was one: good input leaves none."""


def refused(told: str) -> None:
    assert "\n" not in told, told
    REFUSALS.append(told)


@contextmanager
def refused_in_a_line(*errors: type[Exception]) -> Iterator[None]:
    """These errors are answers, of one line."""
    try:
        yield
    except errors as error:
        refused(str(error))


# -- what comes over the bus ---------------------------------------------------------------------

RGB, DEPTH = np.zeros((12, 16, 3), np.uint8), np.full((12, 16), 2.0, np.float32)
CAMERA = Intrinsics(20.0, 20.0, 8.0, 6.0, 16, 12)
STREAMS = {
    "color": [wire.encode_color(RGB, 5 * S), wire.encode_color(RGB, 5 * S, encoding="bgr8")],
    "depth": [wire.encode_depth(DEPTH, 5 * S), wire.encode_depth(DEPTH, 5 * S, encoding="16UC1")],
    "camera_info": [wire.encode_camera_info(CAMERA, 5 * S)],
    "odom": [wire.encode_odometry(Pose(1.0, 2.0, 0.5), 5 * S)],
    "scan": [laser_scan([1.0, 2.0, 3.0], 5 * S)],
}
SENSES = {
    "teleop": [wire.encode_twist(0.1, 0.2), wire.encode_twist_stamped(0.1, 0.2, 5 * S)],
    "battery": [battery_state(0.5, 5 * S)],
    "bumper": [flag(True)],
    "cliff": [
        b"\0\1\0\0" + struct.pack("<iII4sB3xffff", 5, 0, 3, b"cl\0\0", 1, 0.1, 0.0, 0.3, 0.05)
    ],
    "hazards": [hazards([("bump_left", 1), ("cliff_left", 2)], 5 * S)],
}
OPTICAL = (-0.5, 0.5, -0.5, 0.5)
OTHERS: dict[Callable[[bytes, str], object], list[bytes]] = {
    wire.decode_compressed_color: [compressed_color(RGB, 5 * S)],
    wire.decode_pose: [slam_pose(Pose(1.0, 2.0, 0.5), 5 * S)],
    wire.decode_transforms: [tf(("base_link", "camera", (0.1, 0.0, 0.8), OPTICAL), stamp_ns=5 * S)],
    wire.decode_json: [wire.encode_json({"boxes": [[0, 0, 4, 4]], "names": ["bed"]})],
    wire.decode_twist: [wire.encode_twist(0.1, 0.2)],
    wire.peek_stamp: [],
}
LABELS = {"stamp_ns": 5, "boxes": [[0, 0, 4, 4]], "names": ["bed"], "scores": [0.5], "room": None}


def messages(data: bytes) -> None:
    """A CDR message: the first byte says what it is taken for."""
    if not data:
        return
    number, payload = data[0], data[1:]
    names = [*STREAMS, *SENSES, "tf", "labels"]
    decoders = list(OTHERS)
    if number < len(names):
        _file(names[number], payload)
    else:
        with refused_in_a_line(SensorError):
            decoders[number % len(decoders)](payload, "topic")


def _file(name: str, payload: bytes) -> None:
    """As a bus does, which then looks for a frame."""
    clock, changed = ManualClock(1.0), threading.Condition()
    camera = CameraConfig(mount="tf", frame="camera")
    if name in SENSES:
        body = BodySenses(TopicsConfig(), SensesConfig(), clock)
        body.file(name, f"robot/{name}", payload)
        body.felt()
        return
    streams = SensorStreams(BusConfig(), clock, changed, False, camera)
    streams.file_transforms(TF, OTHERS[wire.decode_transforms][0])
    for other, (first, *_) in STREAMS.items():
        streams.file(other, payload if other == name else first)
    if name == "tf":
        streams.file_transforms(TF, payload)
    elif name == "labels":
        streams.file_labels("detections", payload)
    with redirect_stderr(io.StringIO()), changed:
        match = streams.wait_for_match(Deadline.after(0.0, clock), lambda: True)
    with redirect_stderr(io.StringIO()):
        obs = streams.observe(match) if match is not None else None
    if obs is None:
        REFUSALS.append(f"{name}: no frame")
    else:
        assert np.isfinite((obs.pose.x_m, obs.pose.y_m, obs.pose.yaw_rad)).all()
        assert np.isfinite(obs.depth_m).all()


def _numbered() -> list[bytes]:
    told = [*STREAMS.values(), *SENSES.values(), OTHERS[wire.decode_transforms]]
    told.append([wire.encode_json(LABELS)])
    first = [bytes((n,)) + seed for n, seeds in enumerate(told) for seed in seeds]
    count = len(OTHERS)
    start = -(-len(told) // count) * count
    more = [bytes((start + n,)) + seed for n, seeds in enumerate(OTHERS.values()) for seed in seeds]
    return first + more


def mavlink(data: bytes) -> None:
    """What comes over a MAVLink link."""
    rover = rover_bytes(data)
    if not rover.heard or rover.inbox.bad:
        REFUSALS.append("mavlink: nothing of a rover, or broken messages")


# -- what is asked -------------------------------------------------------------------------------


class _Asker:
    """A query."""

    def __init__(self, data: bytes) -> None:
        self.payload, self._data, self.answers = self, data, 0

    def to_bytes(self) -> bytes:
        return self._data

    def reply(self, key: str, answer: str) -> None:
        json.loads(answer)
        self.answers += 1

    def drop(self) -> None:
        pass


def request(data: bytes) -> None:
    """A query: goal, cancel or status; under a harness or not. It is answered whatever it says."""
    if not data:
        return
    number, asker = data[0], _Asker(data[1:])
    requests = Requests(threading.Condition(), lambda topic: topic)
    kind = list(WAITING)[number % len(WAITING)]
    requests.file(kind, kind, asker)
    taken = requests.take()
    if taken is not None:
        terms = Terms(harness=True) if number > 127 else STRICT
        answer: dict[str, object] = {"accepted": True}
        cancel_reason(taken.body)
        try:
            if kind == "goal":
                load(None, terms.read(taken.body).settings)
        except RfNavError as error:
            refused(str(error))
            answer = {"accepted": False, "error": str(error)}
        taken.reply(answer)
    assert asker.answers == 1


GOALS = [
    {"goal": "bed"},
    {"goal": "bed", "episode": "e1", "settings": ["goal.keep_map=true", "panel.experts=['o2f']"]},
    {
        "goal": "bed",
        "log_dir": "x/y",
        "settings": ["control.max_speed_mps=0.3", "bus.mode=peer"],
    },
    {"reason": "enough"},
]


# -- files ---------------------------------------------------------------------------------------


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


def _database_of(write: Callable[[Path], None]) -> bytes:
    path = scratch() / "seed.sqlite"
    path.unlink(missing_ok=True)
    write(path)
    with sqlite3.connect(path) as file:
        file.execute("PRAGMA wal_checkpoint(TRUNCATE)")
    file.close()
    return path.read_bytes()


def _scores(path: Path) -> None:
    file = ScoreFile(path, "model")
    file.load()
    file.keep([(LikelihoodQuestion(f"a {n}", " toilet"), -float(n)) for n in range(5)])


def _spending(path: Path) -> None:
    ledger = Spending(path, Caps(1.0, 1.0))
    ledger.begin("bed")
    ledger.settle(ledger.reserve(1000, "a call"), 500)


def _embeddings() -> bytes:
    path, model = scratch() / "seed.npz", scratch() / "model.bin"
    model.write_bytes(b"model")
    RowFile(path, model).keep({"bed": np.ones((1, 4), np.float32)})
    return path.read_bytes()


def _drawing() -> bytes:
    home = xml(WALLS, ROOMS, door(400, 200), piece("Bed", 600, 200, model="1/cube.obj"))
    return save(scratch() / "seed.sh3d", home, {"1/cube.obj": CUBE.encode()}).read_bytes()


def _gguf() -> bytes:
    def text(value: bytes) -> bytes:
        return struct.pack("<Q", len(value)) + value

    keys = text(b"general.alignment") + struct.pack("<II", 4, 32)
    keys += text(b"general.name") + struct.pack("<I", 8) + text(b"small")
    keys += text(b"tokens") + struct.pack("<IIQ", 9, 8, 2) + text(b"a") + text(b"bc")
    keys += text(b"scores") + struct.pack("<IIQff", 9, 6, 2, 0.5, 1.0)
    tensor = text(b"blk.0") + struct.pack("<IQQIQ", 2, 4, 4, 0, 0)
    head = b"GGUF" + struct.pack("<IQQ", 3, 1, 4) + keys + tensor
    return head.ljust(-(-len(head) // 32) * 32, b"\0") + bytes(64)


def _onnx() -> bytes:
    from onnx import TensorProto, helper

    value = helper.make_tensor_value_info("x", TensorProto.FLOAT, [1, 3])
    weights = helper.make_tensor("w", TensorProto.FLOAT, [3], [0.5, 1.0, 2.0])
    nodes = [helper.make_node("Add", ["x", "w"], ["y"], "add")]
    graph = helper.make_graph(nodes, "g", [value], [value], [weights])
    return bytes(helper.make_model(graph).SerializeToString())


def _shortened(path: Path) -> bytes:
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

ENTRY_POINTS: dict[str, EntryPoint] = {
    "messages": EntryPoint(_numbered(), messages),
    "mavlink": EntryPoint(SEEDS, mavlink),
    "requests": EntryPoint(
        [bytes((n,)) + json.dumps(body).encode() for n in (0, 1, 2, 128) for body in GOALS], request
    ),
    "configuration": EntryPoint(TEXTS, configuration),
    "scenes": EntryPoint(((TESTS / "refs" / "flat.json").read_bytes(),), scene),
    "manifest": EntryPoint((MODELS,), manifest),
    "vocabulary": EntryPoint((WORDS,), vocabulary),
    "onnx": EntryPoint((_onnx(),), onnx_head),
    "gguf": EntryPoint((_gguf(),), gguf_head),
    "recordings": EntryPoint((_shortened(TESTS / "refs" / "lockstep.mcap"),), recording, True),
    "sh3d": EntryPoint((_drawing(),), drawing, True),
    "sh3d drawings": EntryPoint((xml(WALLS, ROOMS, door(400, 200)),), drawing_xml, True),
    "scores": EntryPoint((_database_of(_scores),), scores, True),
    "spending": EntryPoint((_database_of(_spending),), spending, True),
    "embeddings": EntryPoint((_embeddings(),), embeddings, True),
}
