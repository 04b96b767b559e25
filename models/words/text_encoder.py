"""Sentence embeddings: a MiniLM-like encoder through onnxruntime, mean-pooled and normalised."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import onnxruntime
from tokenizers import Tokenizer

from models.errors import ModelFileError
from models.onnx_session import open_session
from models.words.row_file import RowFile, Rows

MAX_TOKENS = 64
MEMO = 10_000  # texts whose rows are kept


class TextEncoder:
    """`model.onnx` and `tokenizer.json` in one directory. Any thread may use it."""

    def __init__(self, directory: Path, threads: int = 1, kept: Path | None = None) -> None:
        """`kept`: a file of rows that were embedded before, which `keep` adds to."""
        self._session: onnxruntime.InferenceSession = open_session(
            Path(directory) / "model.onnx", threads
        )
        self._tokenizer = open_tokenizer(Path(directory) / "tokenizer.json")
        self._kept = RowFile(kept, Path(directory) / "model.onnx") if kept else None
        self._memo: dict[str, Rows] = self._kept.load() if self._kept else {}
        self._known = len(self._memo)
        self._inputs = {i.name for i in self._session.get_inputs()}
        self.dimension = int(self.embed(["a"]).shape[1])

    def embed(self, texts: Sequence[str]) -> Rows:
        """N texts -> (N, D) float32 unit rows, in the texts' order."""
        if not texts:
            return np.zeros((0, self.dimension), np.float32)
        # A row of its own for every text: in an int8 network a neighbour in the same batch
        # shifts the quantisation range, and a text's embedding must not depend on its company.
        return np.concatenate([self._row(text) for text in texts])

    def keep(self) -> str:
        """Keep what was embedded for the next start; what went wrong with the file, or ""."""
        if self._kept is None:
            return ""
        memo = dict(self._memo)
        if len(memo) != self._known:
            self._kept.keep(memo)
            self._known = len(memo)
        return self._kept.error

    def _row(self, text: str) -> Rows:
        row = self._memo.get(text)
        if row is None:
            row = self._embedded(text)
            if len(self._memo) >= MEMO:  # another thread may clear it, too, at any time
                self._memo.clear()
            self._memo[text] = row
        return row

    def _embedded(self, text: str) -> Rows:
        ids = np.array([self._tokenizer.encode(text).ids], np.int64)
        mask = np.ones_like(ids)
        feeds = {"input_ids": ids, "attention_mask": mask, "token_type_ids": np.zeros_like(ids)}
        states = self._session.run(None, {k: v for k, v in feeds.items() if k in self._inputs})[0]
        mean = np.asarray(states, np.float32)
        if mean.ndim == 3:
            mean = mean.mean(axis=1)
        norm = np.linalg.norm(mean, axis=1, keepdims=True)
        return np.asarray(mean / np.maximum(norm, 1e-12), np.float32)


def open_tokenizer(path: Path, remedy: str = "run `rfnav models pull minilm`") -> Tokenizer:
    """A tokenizer that truncates and does not pad. Raises ModelFileError."""
    if not path.is_file():
        raise ModelFileError(f"{path}: missing; {remedy}")
    try:
        tokenizer = Tokenizer.from_file(str(path))
    except Exception as error:  # the binding raises bare Exception
        raise ModelFileError(f"{path}: damaged ({error}); {remedy}") from error
    tokenizer.no_padding()
    tokenizer.enable_truncation(MAX_TOKENS)
    return tokenizer
