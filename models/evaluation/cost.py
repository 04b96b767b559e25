"""What a detector costs: `python -m models.evaluation.cost NAME … --threads N`, in a process of its
own, so that its memory is its own.

Times depend on what else the machine does. A fixed stack of convolutions is timed in turn with the
detector: the ratio of the two tells detectors apart on a machine that is not quiet. So does the
processor's time, which on one thread is what a quiet machine would take.
"""

import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import click
import numpy as np
import onnx
from numpy.typing import NDArray
from onnx import TensorProto, helper, numpy_helper

from models.detection.boxes import letterbox
from models.detection.detections import Detector
from models.detection.detector import MODEL_FILE, DetectorView, OpenDetector
from models.detection.ensemble import DetectorEnsemble, open_detectors
from models.detection.second_look import LOOKS, SecondLook, Sought, look_twice
from models.errors import ModelFileError, told
from models.onnx_session import open_session
from models.store import manifest
from models.words.text_encoder import TextEncoder
from models.words.vocabulary import load_vocabulary

RUNS, WARM = 24, 4  # an even number: of several detectors one may look at every other frame
FRAME = (480, 640, 3)
LAYERS, CHANNELS, SIDE = 3, 64, (120, 160)
"""The reference: 3x3 convolutions of 2.1 G multiplications, about EfficientNet-Lite0's at 640."""


def measure_cost(
    detectors: Sequence[str], second_look: Path | None = None, others_every: int = 1
) -> dict[str, Any]:
    """Bytes of the files, resident memory, and times on 1 and 2 threads, of detectors by name or
    path; with the project's second look or another. Several look as often as they do in a robot."""
    looks = second_look or manifest.fetch("second-look")
    figures: dict[str, Any] = {"bytes": sum(_bytes(manifest.located(d)) for d in detectors)}
    for threads in (1, 2):
        command = [sys.executable, "-m", "models.evaluation.cost", *detectors]
        done = subprocess.run(
            [
                *command,
                "--second-look",
                str(looks),
                "--threads",
                str(threads),
                "--others-every",
                str(others_every),
            ],
            capture_output=True,
            text=True,
            check=False,
            env={**os.environ, "OPENBLAS_NUM_THREADS": "1"},  # as the runtime has it
        )
        if done.returncode:
            raise ModelFileError(
                done.stderr.strip().splitlines()[-1] if done.stderr else "no answer"
            )
        figures[f"threads_{threads}"] = json.loads(done.stdout)
    return figures


def _bytes(detector: Path) -> int:
    return (detector / MODEL_FILE if detector.is_dir() else detector).stat().st_size


def one_process(
    names: Sequence[str], second_look: Path, threads: int, others_every: int = 1
) -> dict[str, float]:
    """Times in ms and memory in MB of this process."""
    encoder = TextEncoder(manifest.fetch("minilm"))
    words = load_vocabulary()
    with tempfile.TemporaryDirectory() as folder:
        reference = open_session(_reference(Path(folder) / "reference.onnx"), threads)
    plain = np.zeros((1, CHANNELS, *SIDE), np.float32)
    rng = np.random.default_rng(0)
    frame = rng.integers(0, 255, FRAME, dtype=np.uint8)
    reference.run(None, {"x": plain})
    before = _resident_mb()
    detector = _opened(names, encoder, threads, others_every)
    detector.set_vocabulary(words.objects, words.rooms)
    view = detector.look(frame) if isinstance(detector, OpenDetector) else None
    times, ratios, parts, busy = [], [], [], []
    for k in range(WARM + RUNS):
        still = _timed(lambda: reference.run(None, {"x": plain}))
        began_cpu = time.process_time()
        mine = _timed(lambda: detector.detect(frame))
        if k >= WARM:
            busy.append(1000 * (time.process_time() - began_cpu))
            times.append(mine)
            ratios.append(mine / still)
            parts.append((still, *_stages(detector, frame, view)))
    middle = np.median(np.array(parts), axis=0)
    memory_mb = _resident_mb() - before
    return {
        "ms": float(np.median(times)),
        "mean_ms": float(np.mean(times)),
        "least_ms": float(np.min(times)),
        "cpu_ms": float(np.median(busy)),
        "least_cpu_ms": float(np.min(busy)),
        "ratio": float(np.median(ratios)),
        "reference_ms": float(middle[0]),
        "resize_ms": float(middle[1]),
        "name_ms": float(middle[2]),
        "memory_mb": memory_mb,
        **_twice(detector, second_look, encoder, frame, threads),
    }


def _twice(
    detector: Detector, path: Path, encoder: TextEncoder, frame: NDArray[np.uint8], threads: int
) -> dict[str, float]:
    """A frame for a goal that the detector has no word for, and the memory that this adds."""
    if not isinstance(detector, OpenDetector):
        return {}
    before = _resident_mb()
    second = SecondLook(path, encoder, threads)
    sought = Sought(0, second.likeness(["umbrella"]), LOOKS)
    times = [_timed(lambda: _both(detector, second, sought, frame)) for _ in range(WARM + RUNS)]
    taken = float(np.median(times[WARM:]))
    return {"twice_ms": taken, "twice_memory_mb": _resident_mb() - before}


def _opened(
    names: Sequence[str], encoder: TextEncoder, threads: int, others_every: int
) -> Detector:
    found = open_detectors(names, encoder, threads)
    if len(found) == 1:
        return next(iter(found.values()))
    # A frame of noise is neither a photograph nor a rendering.
    return DetectorEnsemble(found, "photographs", others_every)


def _both(
    detector: OpenDetector, second: SecondLook, sought: Sought, frame: NDArray[np.uint8]
) -> None:
    view = detector.look(frame)
    detector.name(view)
    look_twice(detector, second, sought, frame, view)


def _stages(
    detector: Detector, frame: NDArray[np.uint8], view: DetectorView | None
) -> tuple[float, float]:
    """Fitting the frame into the network's input, and naming; 0 for other contracts."""
    if view is None or not isinstance(detector, OpenDetector):
        return 0.0, 0.0
    size = detector.size
    return _timed(lambda: letterbox(frame, *size)), _timed(lambda: detector.name(view))


def _timed(work: Callable[[], object]) -> float:
    began = time.perf_counter()
    work()
    return 1000 * (time.perf_counter() - began)


def _reference(path: Path) -> Path:
    rng = np.random.default_rng(0)
    nodes, weights = [], []
    for k in range(LAYERS):
        values = rng.normal(0, 0.02, (CHANNELS, CHANNELS, 3, 3)).astype(np.float32)
        weights.append(numpy_helper.from_array(values, f"w{k}"))
        source, target = ("x" if k == 0 else f"y{k - 1}"), f"y{k}"
        nodes.append(helper.make_node("Conv", [source, f"w{k}"], [target], pads=[1, 1, 1, 1]))
    shape = [1, CHANNELS, *SIDE]
    ends = (
        [helper.make_tensor_value_info("x", TensorProto.FLOAT, shape)],
        [helper.make_tensor_value_info(f"y{LAYERS - 1}", TensorProto.FLOAT, shape)],
    )
    graph = helper.make_graph(nodes, "reference", *ends, weights)
    model = helper.make_model(graph, opset_imports=[helper.make_opsetid("", 17)], ir_version=8)
    onnx.save(model, str(path))
    return path


def _resident_mb() -> float:
    for line in Path("/proc/self/status").read_text().splitlines():
        if line.startswith("VmRSS:"):
            return int(line.split()[1]) / 1024
    return float("nan")


@click.command()
@click.argument("names", nargs=-1, required=True)
@click.option("--second-look", type=click.Path(path_type=Path), help="Default: the project's.")
@click.option("--threads", default=1, show_default=True)
@click.option("--others-every", default=2, show_default=True, help="As in the configuration.")
def main(names: tuple[str, ...], second_look: Path | None, threads: int, others_every: int) -> None:
    """Time a detector, or several as one, on one 640x480 frame; figures as JSON."""
    looks = second_look or manifest.fetch("second-look")
    click.echo(json.dumps(one_process(names, looks, threads, others_every)))


if __name__ == "__main__":
    told(main)
