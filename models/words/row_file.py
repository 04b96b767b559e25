"""Embeddings that outlive the process: a vocabulary's words are the same at the next start."""

import hashlib
import os
import platform
import struct
import tokenize
import zipfile
import zlib
from collections.abc import Mapping
from pathlib import Path
from typing import Final

import numpy as np
import onnxruntime
from numpy.typing import NDArray

from models.checksum import sha256

Rows = NDArray[np.float32]
# What a zip and arrays in it raise where they are spoilt.
_DAMAGE: Final = (
    OSError, ValueError, TypeError, KeyError, EOFError, MemoryError, OverflowError,
    zipfile.BadZipFile, zlib.error, RuntimeError, struct.error, IndexError,
    tokenize.TokenError, SyntaxError,  # an array's head is read as Python's
)  # fmt: skip


class RowFile:
    """Rows by text of one model, on one kind of processor. A file that cannot be used is not:
    `load` returns nothing, and `error` says why."""

    def __init__(self, path: Path, model: Path) -> None:
        self._path = path
        self._identity = "/".join((sha256(model), onnxruntime.__version__, _processor()))
        self.error = ""

    def load(self) -> dict[str, Rows]:
        """Texts -> (1, D) float32, to the last bit as they were kept."""
        try:
            with self._path.open("rb") as stream, np.load(stream, allow_pickle=False) as file:
                if str(file["identity"]) != self._identity:
                    return {}
                texts, rows = file["texts"], np.asarray(file["rows"], np.float32)
            if texts.dtype.kind != "U" or rows.ndim != 2 or texts.shape != rows.shape[:1]:
                raise ValueError(f"{texts.shape} texts and {rows.shape} rows")
            if not np.isfinite(rows).all():
                raise ValueError("a row is not finite")
        except FileNotFoundError:
            return {}
        except _DAMAGE as error:
            told = " ".join(str(error).split())
            self.error = f"{self._path}: cannot be read ({told}); it is made anew"
            return {}
        return {str(text): row[None] for text, row in zip(texts, rows, strict=True)}

    def keep(self, rows: Mapping[str, Rows]) -> None:
        """In place of what was kept before; whole or not at all."""
        draft = self._path.with_name(f".{self._path.name}.{os.getpid()}")
        try:
            self._path.parent.mkdir(parents=True, exist_ok=True)
            with draft.open("wb") as file:
                texts = np.array(list(rows))
                together = np.concatenate(list(rows.values()))
                np.savez(file, identity=np.array(self._identity), texts=texts, rows=together)
            draft.replace(self._path)
        except OSError as error:
            self.error = f"{self._path}: cannot be written ({error.strerror})"


def _processor() -> str:
    """What an int8 network's last bits depend on."""
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        return platform.machine()
    told = {line.split(":", 1)[0].strip(): line for line in reversed(lines) if ":" in line}
    features = told.get("flags", "") + told.get("Features", "")  # of x86-64, of aarch64
    return f"{platform.machine()} {hashlib.sha256(features.encode()).hexdigest()}"
