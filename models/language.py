"""A local language model that scores: log P(continuation | context), through llama.cpp."""

import hashlib
import os
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from models.errors import ModelError

CHUNK = 16
"""Tokens evaluated at once; sums of another batch size differ in their last bits."""


class LanguageModel:
    """A GGUF causal model. One thread at a time may use it.

    The context of the last call stays in the KV cache: whole chunks that a new one shares with it
    at the front are not computed again, so ask questions that share a prefix one after another.
    Chunks begin at fixed places: a score depends on its text alone, to the last bit, and not on
    what was asked before.
    """

    def __init__(self, path: Path, threads: int = 1, context: int = 256) -> None:
        _check(Path(path))
        # libgomp reads this when it is loaded: spinning threads would starve the control loop.
        os.environ.setdefault("OMP_WAIT_POLICY", "passive")
        import llama_cpp
        from llama_cpp import Llama

        try:
            self._llama = Llama(
                model_path=str(path),
                n_ctx=context,
                n_batch=context,
                n_ubatch=context,
                n_threads=threads,
                n_threads_batch=threads,
                logits_all=True,  # context * vocabulary * 4 bytes: keep the context small
                verbose=False,
            )
        except Exception as error:  # the binding raises ValueError, AssertionError, ...
            reason = " ".join(str(error).split())[:120]
            raise ModelError(f"{path}: llama.cpp cannot load it ({reason})") from error
        self._context = context
        self.identity = f"{_sha256(Path(path))}/llama-cpp-python {llama_cpp.__version__}"
        """What the scores depend on, but for the processor."""
        self._cached: list[int] = []  # the last context's tokens

    def score(self, context: str, continuations: Sequence[str]) -> tuple[float, ...]:
        """Sum of log P over each continuation's tokens, given the context; natural logarithm.

        A continuation should start with its space (" toilet").
        """
        prefix = self._tokens(context, first=True)
        if not prefix:
            raise ModelError("the context of a score is empty; give at least one word")
        return tuple(self._one(prefix, self._tokens(text, first=False)) for text in continuations)

    def _tokens(self, text: str, first: bool) -> list[int]:
        return list(self._llama.tokenize(text.encode(), add_bos=first, special=False))

    def _one(self, prefix: list[int], tail: list[int]) -> float:
        if not tail:
            raise ModelError("a continuation to score is empty; give at least one word")
        if len(prefix) + len(tail) > self._context:
            raise ModelError(
                f"{len(prefix) + len(tail)} tokens do not fit the context of {self._context}; "
                "shorten the prompt or raise the model's context"
            )
        self._evaluate(prefix)
        if len(tail) > 1:
            self._llama.n_tokens = len(prefix)
            self._llama.eval(tail[:-1])
        first = len(prefix) - 1
        logits = np.asarray(self._llama.scores[first : first + len(tail)], np.float64)
        top = logits.max(axis=1)
        total = top + np.log(np.exp(logits - top[:, None]).sum(axis=1))
        return float((logits[np.arange(len(tail)), tail] - total).sum())

    def _evaluate(self, prefix: list[int]) -> None:
        """Bring the logits and keys of a context into the cache, chunk by chunk."""
        if prefix == self._cached:
            return
        shared = next(
            (n for n, (a, b) in enumerate(zip(prefix, self._cached, strict=False)) if a != b),
            min(len(prefix), len(self._cached)),
        )
        start = shared // CHUNK * CHUNK
        self._cached = []
        self._llama.n_tokens = start
        for at in range(start, len(prefix), CHUNK):
            self._llama.eval(prefix[at : at + CHUNK])
        self._cached = prefix

    def forget(self) -> None:
        """Drop the cached prefix, for a cold measurement."""
        self._cached = []


def _sha256(path: Path) -> str:
    with path.open("rb") as stream:
        return hashlib.file_digest(stream, "sha256").hexdigest()


def _check(path: Path) -> None:
    remedy = "check the path or run `rfnav models pull`"
    if not path.is_file():
        raise ModelError(f"{path}: no such model file; {remedy}")
    with path.open("rb") as stream:
        if stream.read(4) != b"GGUF":
            raise ModelError(f"{path}: not a GGUF file, or damaged; {remedy}")
