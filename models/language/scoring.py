"""Small local language models, through llama.cpp: they score, log P(continuation | context), where
the context may begin with vectors in place of words."""

import ctypes
import hashlib
from collections.abc import Sequence
from dataclasses import dataclass, field
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
Vectors = NDArray[np.float32]


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
        self.sha256 = sha256(path)
        """Of its file."""
        self.identity = f"{self.sha256}/llama-cpp-python {llama_cpp.__version__}"
        """What the scores depend on, but for the processor."""
        self.width: int = self._llama.n_embd()
        """Of a token's vector."""
        self._cached: _Prefix | None = None  # the last context
        self._ends: dict[_Prefix, _End] = {}  # of contexts, the newest last

    def score(
        self, context: str, continuations: Sequence[str], seen: Vectors | None = None
    ) -> tuple[float, ...]:
        """Sum of log P over each continuation's tokens, given the context; natural logarithm.

        A continuation should start with its space (" toilet"). `seen` (n, width): what stands
        before the context, in the model's own space of tokens.
        """
        words = self._tokens(context, first=seen is None)
        if not words:
            raise ModelFileError("the context of a score is empty; give at least one word")
        prefix = _Prefix(tuple(words)) if seen is None else self._prefix(seen, words)
        return tuple(self._one(prefix, self._tokens(text, first=False)) for text in continuations)

    def _prefix(self, seen: Vectors, words: list[int]) -> "_Prefix":
        seen = np.ascontiguousarray(seen, np.float32)
        if seen.ndim != 2 or not len(seen) or seen.shape[1] != self.width:
            raise ModelFileError(
                f"what was seen is {seen.shape}, this model's tokens are (n, {self.width}); it was "
                "made for another language model"
            )
        if not np.isfinite(seen).all():
            raise ModelFileError("what was seen is not finite")
        digest = hashlib.blake2b(seen.tobytes(), digest_size=16).digest()
        return _Prefix(tuple(words), digest, seen)

    def _tokens(self, text: str, first: bool) -> list[int]:
        return list(self._llama.tokenize(text.encode(), add_bos=first, special=False))

    def _one(self, prefix: "_Prefix", tail: list[int]) -> float:
        if not tail:
            raise ModelFileError("a continuation to score is empty; give at least one word")
        size = len(prefix) + len(tail)
        if size > self._context:
            raise ModelFileError(
                f"{size} tokens do not fit the context of {self._context}; "
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

    def _end(self, prefix: "_Prefix") -> "_End":
        """What follows a context: kept, so that another word there costs no evaluation."""
        end = self._ends.pop(prefix, None)
        if end is None:
            self._evaluate(prefix)
            row = np.array(self._llama.scores[len(prefix) - 1], np.float32)
            end = _End(row, float(_totals(row[None].astype(np.float64))[0]))
        self._ends[prefix] = end
        if len(self._ends) > ENDS:
            del self._ends[next(iter(self._ends))]
        return end

    def _evaluate(self, prefix: "_Prefix") -> None:
        """Bring the logits and keys of a context into the cache, chunk by chunk."""
        if prefix == self._cached:
            return
        before, self._cached = self._cached, None
        if prefix.seen is not None:
            self._read_seen(prefix.seen, prefix.words)
        else:
            words, start = list(prefix.words), _shared(prefix, before) // CHUNK * CHUNK
            self._llama.n_tokens = start
            for at in range(start, len(words), CHUNK):
                self._llama.eval(words[at : at + CHUNK])
        self._cached = prefix

    def _read_seen(self, seen: Vectors, words: tuple[int, ...]) -> None:
        """Begin the cache with vectors, as if each were a token's own, and with words after them;
        what follows is worked out for the last word alone."""
        import llama_cpp

        context, size = self._llama.ctx, len(seen) + len(words)
        llama_cpp.llama_memory_clear(llama_cpp.llama_get_memory(context), False)
        self._decode(0, seen)
        self._decode(len(seen), words)
        self._llama.n_tokens = size
        logits = llama_cpp.llama_get_logits_ith(context, -1)
        last = np.ctypeslib.as_array(logits, shape=(self._llama.n_vocab(),))
        self._llama.scores[size - 1] = last

    def _decode(self, at: int, what: Vectors | tuple[int, ...]) -> None:
        """Take in vectors (n, width), or tokens with the logits of the last."""
        import llama_cpp

        n, words = len(what), isinstance(what, tuple)
        batch = llama_cpp.llama_batch_init(n, 0 if words else self.width, 1)
        try:
            batch.n_tokens = n
            for i in range(n):
                batch.pos[i], batch.n_seq_id[i], batch.seq_id[i][0] = at + i, 1, 0
                batch.logits[i] = words and i == n - 1
                if words:
                    batch.token[i] = what[i]
            if not isinstance(what, tuple):
                ctypes.memmove(batch.embd, what.ctypes.data, what.nbytes)
            failed = llama_cpp.llama_decode(self._llama.ctx, batch)
        finally:
            llama_cpp.llama_batch_free(batch)
        if failed:
            raise ModelFileError(f"llama.cpp: cannot take in what was seen (code {failed})")

    def forget(self) -> None:
        """Drop what is cached, for a cold measurement."""
        self._cached = None
        self._ends.clear()


@dataclass(frozen=True)
class _Prefix:
    """A context: its words' tokens, after vectors (n, width) that `digest` stands for, if any."""

    words: tuple[int, ...]
    digest: bytes = b""
    seen: Vectors | None = field(default=None, compare=False, repr=False)

    def __len__(self) -> int:
        return len(self.words) + (0 if self.seen is None else len(self.seen))


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


def _shared(prefix: _Prefix, before: _Prefix | None) -> int:
    """How many tokens two contexts of words have in common at the front."""
    if before is None or before.seen is not None:
        return 0
    pairs = zip(prefix.words, before.words, strict=False)
    most = min(len(prefix), len(before))
    return next((n for n, (a, b) in enumerate(pairs) if a != b), most)
