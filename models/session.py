"""Opening an ONNX file: one place for thread counts, spinning, and errors in one line."""

from pathlib import Path

import onnxruntime

from models.errors import ModelError


def open_session(path: Path, threads: int = 1) -> onnxruntime.InferenceSession:
    """A CPU session with `threads` threads that never spin. Raises ModelError."""
    if not path.is_file():
        raise ModelError(f"{path}: no such model file; check the path or run `rfnav models pull`")
    options = onnxruntime.SessionOptions()
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
        reason = " ".join(str(error).split())[:120]
        raise ModelError(
            f"{path}: not a usable ONNX file ({reason}); fetch it again or name another"
        ) from error
