"""Opening and running an ONNX file: one place for threads, spinning, memory, and errors in one
line."""

from collections.abc import Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import onnxruntime
from numpy.typing import NDArray

from models.errors import ModelFileError
from models.onnx_file import refuse_external_data

DEFAULT_SIDE_PX = 640
"""Input side of a network that leaves it open."""


def open_session(path: Path, threads: int = 1) -> onnxruntime.InferenceSession:
    """A CPU session with `threads` threads that never spin; what one session computes in, others
    compute in next. Raises ModelFileError, also for a file of which parts lie in others."""
    if not path.is_file():
        raise ModelFileError(
            f"{path}: no such model file; check the path or run `rfnav models pull`"
        )
    refuse_external_data(path)
    _share_memory()
    options = onnxruntime.SessionOptions()
    options.add_session_config_entry("session.use_env_allocators", "1")
    options.intra_op_num_threads = threads
    options.inter_op_num_threads = 1
    options.log_severity_level = 4
    options.add_session_config_entry("session.intra_op.allow_spinning", "0")
    options.add_session_config_entry("session.inter_op.allow_spinning", "0")
    try:
        return onnxruntime.InferenceSession(
            str(path), sess_options=options, providers=["CPUExecutionProvider"]
        )
    except Exception as error:  # onnxruntime's exceptions share no base but Exception
        raise ModelFileError(
            f"{path}: not a usable ONNX file ({_line(error)}); fetch it again or name another"
        ) from error


@cache
def _share_memory() -> None:
    """One arena for all sessions of the process, which run in turn: else each keeps its own."""
    kind, where = onnxruntime.OrtAllocatorType.ORT_ARENA_ALLOCATOR, onnxruntime.OrtMemType.DEFAULT
    memory = onnxruntime.OrtMemoryInfo("Cpu", kind, 0, where)
    as_asked = onnxruntime.OrtArenaCfg({"arena_extend_strategy": 1})  # not twice as much each time
    onnxruntime.create_and_register_allocator(memory, as_asked)


def run(
    session: onnxruntime.InferenceSession, feeds: Mapping[str, NDArray[Any]], path: Path
) -> list[NDArray[np.float32]]:
    """All outputs as float32. Raises ModelFileError when the graph cannot take these inputs."""
    try:
        return [np.asarray(out, np.float32) for out in session.run(None, dict(feeds))]
    except Exception as error:  # onnxruntime's exceptions share no base but Exception
        shapes = ", ".join(f"{name} {value.shape}" for name, value in feeds.items())
        raise ModelFileError(f"{path}: does not run on {shapes} ({_line(error)})") from error


def image_size(shape: Sequence[Any], path: Path, side_px: int = DEFAULT_SIDE_PX) -> tuple[int, int]:
    """Height and width of an image input (1, 3, H, W), `side_px` where they are left open. Raises
    ModelFileError for any other."""
    if len(shape) != 4 or (isinstance(shape[1], int) and shape[1] != 3):
        raise ModelFileError(f"{path}: input {list(shape)} is not an image; expected (1, 3, H, W)")
    height, width = (s if isinstance(s, int) and s > 0 else side_px for s in shape[2:])
    return height, width


def _line(error: Exception) -> str:
    return " ".join(str(error).split())[:120]
