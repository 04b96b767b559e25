"""Small local language models, through llama.cpp: they score, log P(continuation | context)."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from models.checksum import sha256
from models.errors import ModelFileError
from models.language.gguf import load

CHUNK = 16
"""Tokens evaluated at once; sums of another batch size differ in their last bits."""
ENDS = 96
"""Contexts whose next-word logits are kept (200 kB each, for 49,152 words): a new goal of one token
is scored in all of them without the model."""


class LanguageModel:
    """A GGUF causal model. One thread at a time may use it.

    The context of the last call stays in the KV cache: whole chunks that a new one shares with it
    at the front are not computed again, so ask questions that share a prefix one after another.
    Chunks begin at fixed places: a score depends on its text alone, to the last bit, and not on
    what was asked before.
    """

    def __init__(self, path: Path, threads: int = 1, context: int = 256) -> None:
        self._llama = load(
            path,
            threads,
            n_ctx=context,
            n_batch=context,
            n_ubatch=context,
            logits_all=True,  # context * vocabulary * 4 bytes: keep the context small
        )
        import llama_cpp

        self._context = context
        self.identity = f"{sha256(path)}/llama-cpp-python {llama_cpp.__version__}"
        """What the scores depend on, but for the processor."""
        self._cached: list[int] = []  # the last context's tokens
        self._ends: dict[tuple[int, ...], _End] = {}  # of contexts, the newest last

    def score(self, context: str, continuations: Sequence[str]) -> tuple[float, ...]:
        """Sum of log P over each continuation's tokens, given the context; natural logarithm.

        A continuation should start with its space (" toilet").
        """
        prefix = self._tokens(context, first=True)
        if not prefix:
            raise ModelFileError("the context of a score is empty; give at least one word")
        return tuple(self._one(prefix, self._tokens(text, first=False)) for text in continuations)

    def _tokens(self, text: str, first: bool) -> list[int]:
        return list(self._llama.tokenize(text.encode(), add_bos=first, special=False))

    def _one(self, prefix: list[int], tail: list[int]) -> float:
        if not tail:
            raise ModelFileError("a continuation to score is empty; give at least one word")
        if len(prefix) + len(tail) > self._context:
            raise ModelFileError(
                f"{len(prefix) + len(tail)} tokens do not fit the context of {self._context}; "
                "shorten the prompt or raise the model's context"
            )
        end = self._end(prefix)
        parts = [float(end.logits[tail[0]]) - end.total]
        if len(tail) > 1:
            self._evaluate(prefix)
            self._llama.n_tokens = len(prefix)
            self._llama.eval(tail[:-1])
            rows = np.asarray(
                self._llama.scores[len(prefix) : len(prefix) + len(tail) - 1], np.float64
            )
            parts += list(rows[np.arange(len(tail) - 1), tail[1:]] - _totals(rows))
        return float(np.sum(parts))

    def _end(self, prefix: list[int]) -> "_End":
        """What follows a context: kept, so that another word there costs no evaluation."""
        key = tuple(prefix)
        end = self._ends.pop(key, None)
        if end is None:
            self._evaluate(prefix)
            row = np.array(self._llama.scores[len(prefix) - 1], np.float32)
            end = _End(row, float(_totals(row[None].astype(np.float64))[0]))
        self._ends[key] = end
        if len(self._ends) > ENDS:
            del self._ends[next(iter(self._ends))]
        return end

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
        """Drop what is cached, for a cold measurement."""
        self._cached = []
        self._ends.clear()


@dataclass(frozen=True)
class _End:
    """What a model expects after a context."""

    logits: NDArray[np.float32]  # (V,)
    total: float  # log of the sum of their exponentials


def _totals(logits: NDArray[np.float64]) -> NDArray[np.float64]:
    """(N, V) -> (N,) logarithms of the sums of exponentials."""
    top = logits.max(axis=1)
    totals: NDArray[np.float64] = top + np.log(np.exp(logits - top[:, None]).sum(axis=1))
    return totals
