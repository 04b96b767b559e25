"""Opening a GGUF file, through llama.cpp, with errors in one line."""

import os
from pathlib import Path
from typing import Any

from models.errors import ModelFileError
from models.language.gguf_file import refuse_damaged


def load(path: Path, threads: int, **settings: Any) -> Any:
    """A llama_cpp.Llama of this file; ModelFileError, one line, when it cannot be."""
    _check(Path(path))
    # libgomp reads this when it is loaded: spinning threads would starve the control loop.
    os.environ.setdefault("OMP_WAIT_POLICY", "passive")
    from llama_cpp import Llama

    try:
        return Llama(
            model_path=str(path),
            n_threads=threads,
            n_threads_batch=threads,
            verbose=False,
            **settings,
        )
    except Exception as error:  # the binding raises ValueError, AssertionError, ...
        reason = " ".join(str(error).split())[:120]
        raise ModelFileError(f"{path}: llama.cpp cannot load it ({reason})") from error


def _check(path: Path) -> None:
    if not path.is_file():
        raise ModelFileError(
            f"{path}: no such model file; check the path or run `rfnav models pull`"
        )
    refuse_damaged(path)
