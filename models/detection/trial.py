"""A detector that nobody knows is tried in a process of its own, with limits of time and memory:
its graph may loop without end, or ask for all there is.

`python -m models.detection.trial` is that process: it reads what to try, and writes what it found,
as JSON.
"""

import json
import os
import re
import resource
import signal
import subprocess
import sys
import time
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from models.detection.detections import Detector, RawDetections
from models.detection.detector import open_detector
from models.detection.grounding import GroundingDetector
from models.errors import ModelFileError
from models.store import manifest
from models.words.text_encoder import TextEncoder
from models.words.vocabulary import load_vocabulary

RENDERS = tuple(
    Path(__file__).parent / "renders" / f"{room}.jpg"
    for room in ("living-room", "bedroom", "bathroom")
)
"""Three frames of `hil-sim frames --frames 100 --split val --seed 5000`."""
NO_MEMORY = re.compile("bad.alloc|[Ff]ailed to allocate|[Cc]annot allocate|MemoryError")


@dataclass(frozen=True)
class Limits:
    """What a trial may take: seconds in all, and MB of address space beside what is loaded before.
    A network of 100 MB takes some 1,500."""

    seconds: float = 60.0
    memory_mb: int = 4000


@dataclass(frozen=True)
class TrialReport:
    """What a trial found: the detector's capabilities, what a 640x480 frame took on one thread, the
    memory that opening it and three frames added, and what it saw in each picture asked for, with
    the default words."""

    capabilities: dict[str, Any]
    frame_ms: float
    memory_mb: float
    seen: tuple[RawDetections, ...]


def tried(path: Path, limits: Limits, pictures: Sequence[Path] = ()) -> TrialReport:
    """Open the detector and have it answer for frames of several kinds, then for pictures, in a
    process of its own. Raises ModelFileError for what it, or a picture, is not fit for."""
    for picture in pictures:
        _check_there(picture)
    job = {"path": str(path), "pictures": [str(p) for p in pictures], **asdict(limits)}
    try:
        done = subprocess.run(
            [sys.executable, "-m", "models.detection.trial"],
            input=json.dumps(job).encode(),
            capture_output=True,
            check=False,
            timeout=limits.seconds,
            env={**os.environ, "OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"},
        )
    except subprocess.TimeoutExpired as error:
        raise ModelFileError(
            f"{path}: had not answered after {limits.seconds:g} s of its trial; it may never end; "
            "if it is only slow, take it in with a higher --limit-s"
        ) from error
    try:
        found = json.loads(done.stdout)
    except ValueError as error:
        raise ModelFileError(f"{path}: its trial {_ended(done)}; it is not taken") from error
    if "error" in found:
        raise ModelFileError(found["error"])
    seen = tuple(_detections(rows) for rows in found.pop("seen"))
    return TrialReport(seen=seen, **found)


def read_picture(path: Path) -> NDArray[np.uint8]:
    """(H, W, 3) RGB, of any picture: grey, of 16 bits, with alpha. Raises ModelFileError."""
    _check_there(path)
    try:
        bgr = cv2.imdecode(np.fromfile(path, np.uint8), cv2.IMREAD_COLOR)
    except cv2.error:  # an empty file, or more pixels than OpenCV reads
        bgr = None
    if bgr is None:
        raise ModelFileError(f"{path}: not a picture that can be read; give a JPEG or PNG")
    return np.asarray(cv2.cvtColor(bgr, cv2.COLOR_BGR2RGB), np.uint8)


def _check_there(picture: Path) -> None:
    if not picture.is_file():
        raise ModelFileError(f"{picture}: no such picture")


def _ended(done: subprocess.CompletedProcess[bytes]) -> str:
    """How a process ended that found nothing."""
    said = done.stderr.decode(errors="replace").strip().splitlines() or ["it said nothing"]
    if NO_MEMORY.search(said[-1]):
        return "asked for more memory than it may have"
    if done.returncode < 0:
        return f"ended by {signal.Signals(-done.returncode).name}"
    return f"ended with status {done.returncode} ({said[-1][:120]})"


def _detections(rows: dict[str, Any]) -> RawDetections:
    count, floats = len(rows["scores"]), np.float32
    return RawDetections(
        np.array(rows["boxes_px"], floats).reshape(count, 4),
        np.array(rows["scores"], floats),
        np.array(rows["labels"], np.int32),
        np.array(rows["embeddings"], floats).reshape(count, -1 if count else 0),
        np.array(rows["rooms"], floats),
        np.array(rows["scene"], floats),
    )


def _try_here(job: dict[str, Any]) -> dict[str, Any]:
    """In the process of its own."""
    encoder, words = TextEncoder(manifest.locate("minilm")), load_vocabulary()
    _limit(job["seconds"], job["memory_mb"])
    path = Path(job["path"])
    try:
        before_mb = _resident_mb()
        detector = open_detector(path, "auto", encoder)
        opened_mb = _resident_mb() - before_mb
        detector.set_vocabulary(words.objects, words.rooms)  # whose texts take memory, too
        if isinstance(detector, GroundingDetector):
            detector.look_for(0)  # else it need not look
        before_mb = _resident_mb()
        frame_ms = _frames(detector, path)
        memory_mb = opened_mb + _resident_mb() - before_mb
        seen = [detector.detect(read_picture(Path(p)))._asdict() for p in job["pictures"]]
    except ModelFileError as error:
        if NO_MEMORY.search(f"{error} {error.__cause__}"):
            error = ModelFileError(
                f"{path}: asks for more memory than {job['memory_mb']} MB; it is not taken; raise "
                "--limit-mb if it is only large"
            )
        raise error from None
    return {
        "capabilities": detector.capabilities,
        "frame_ms": frame_ms,
        "memory_mb": memory_mb,
        "seen": [{k: v.tolist() for k, v in rows.items()} for rows in seen],
    }


def _frames(detector: Detector, path: Path) -> float:
    """Milliseconds of the faster of two 640x480 frames."""
    noise = np.random.default_rng(0).integers(0, 255, (480, 640, 3), dtype=np.uint8)
    taken_s = []
    for frame in (noise[:1, :1], np.zeros_like(noise), noise):
        began_s = time.perf_counter()
        seen = detector.detect(np.ascontiguousarray(frame))
        taken_s.append(time.perf_counter() - began_s)
        if not (np.isfinite(seen.boxes_px).all() and (seen.scores <= 1).all()):
            raise ModelFileError(
                f"{path}: gives scores above 1; export it with its last activation, so that they "
                "are in 0..1"
            )
    return 1000 * min(taken_s[1:])


def _limit(seconds: float, memory_mb: int) -> None:
    """Of this process: of time too, should the one that waits for it be gone."""
    in_use = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
    for what, most in (
        (resource.RLIMIT_AS, in_use + memory_mb * 2**20),
        (resource.RLIMIT_CPU, int(2 * seconds) + 1),
        (resource.RLIMIT_CORE, 0),
    ):
        hard = resource.getrlimit(what)[1]
        most = most if hard == resource.RLIM_INFINITY else min(most, hard)
        resource.setrlimit(what, (most, most))


def _resident_mb() -> float:
    return int(Path("/proc/self/statm").read_text().split()[1]) * resource.getpagesize() / 2**20


def main() -> None:
    """Read a job from stdin, write what was found, or the error, to stdout."""
    job = json.load(sys.stdin)
    try:
        found = _try_here(job)
    except ModelFileError as error:
        found = {"error": str(error)}
    except MemoryError:
        found = {
            "error": f"{job['path']}: asks for more memory than {job['memory_mb']} MB; it is not "
            "taken"
        }
    json.dump(found, sys.stdout)


if __name__ == "__main__":
    main()
