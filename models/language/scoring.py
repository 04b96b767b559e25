"""Local language models, through llama.cpp: small ones score, log P(continuation | context); large
ones reply, under a grammar and in bounded time."""

import ctypes
import hashlib
import math
import os
import threading
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from models.errors import ModelFileError, OverdueError

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
        self.identity = f"{_sha256(Path(path))}/llama-cpp-python {llama_cpp.__version__}"
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


class ReasoningModel:
    """A GGUF chat model of 3 billion parameters or more. One thread at a time may use it.

    `handler` is one of llama-cpp-python's chat handlers, for models that see.
    """

    def __init__(
        self,
        path: Path,
        threads: int = 1,
        context: int = 2048,
        gpu_layers: int = 0,
        handler: Any = None,
    ) -> None:
        self._llama = load(
            path, threads, n_ctx=context, n_gpu_layers=gpu_layers, chat_handler=handler
        )
        self._alarm = _Alarm(self._llama)

    def close(self) -> None:
        """Free it; not needed before the process ends."""
        self._llama.close()

    def reply(
        self,
        messages: list[dict[str, Any]],
        grammar: str,
        max_tokens: int,
        seconds: float = math.inf,
    ) -> str:
        """The answer to a conversation, held to a GBNF grammar and cut off at `max_tokens`. Raises
        OverdueError after `seconds`, in the midst of a prompt or an answer, and ModelFileError."""
        from llama_cpp.llama_grammar import LlamaGrammar

        try:
            held = LlamaGrammar.from_string(grammar, verbose=False)
            with self._alarm.after(seconds):
                chunks = self._llama.create_chat_completion(
                    messages, grammar=held, max_tokens=max_tokens, temperature=0.0, stream=True
                )
                return "".join(self._told(chunk) for chunk in chunks)
        except (ValueError, RuntimeError) as error:  # the binding's, for all that goes wrong
            raise self._failed(error, seconds) from error

    def _told(self, chunk: Any) -> str:
        if self._alarm.rang:
            raise RuntimeError("too late")
        return chunk["choices"][0]["delta"].get("content") or ""

    def _failed(self, error: Exception, seconds: float) -> ModelFileError:
        """What a call is answered that ended early; leaves nothing of it in the cache."""
        import llama_cpp

        self._llama.reset()
        llama_cpp.llama_memory_clear(llama_cpp.llama_get_memory(self._llama.ctx), True)
        if self._alarm.rang:
            return OverdueError(f"no answer in {seconds:.2f} s")
        return ModelFileError(f"llama.cpp: {' '.join(str(error).split())[:160]}")


class _Alarm:
    """Ends llama.cpp's work from outside, between two steps of a computation.

    llama.cpp asks a C function whether to go on. Python's would need the interpreter's lock at
    each of a thousand steps a token; strlen of one byte that is zero or not does not.
    """

    def __init__(self, llama: Any) -> None:
        import llama_cpp

        self._byte = ctypes.create_string_buffer(2)
        self._ask = ctypes.cast(ctypes.CDLL(None).strlen, llama_cpp.ggml_abort_callback)
        address = ctypes.cast(self._byte, ctypes.c_void_p)
        llama_cpp.llama_set_abort_callback(llama.ctx, self._ask, address)

    @property
    def rang(self) -> bool:
        return self._byte.raw[0] != 0

    @contextmanager
    def after(self, seconds: float) -> Iterator[None]:
        self._byte[0] = b"\0"
        timer = threading.Timer(max(0.0, seconds), self._ring) if math.isfinite(seconds) else None
        if timer is not None:
            timer.daemon = True
            timer.start()
        try:
            yield
        finally:
            if timer is not None:
                timer.cancel()
                timer.join()  # or it might ring into the next call

    def _ring(self) -> None:
        self._byte[0] = b"\1"


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


def _sha256(path: Path) -> str:
    with path.open("rb") as stream:
        return hashlib.file_digest(stream, "sha256").hexdigest()


def _check(path: Path) -> None:
    remedy = "check the path or run `rfnav models pull`"
    if not path.is_file():
        raise ModelFileError(f"{path}: no such model file; {remedy}")
    with path.open("rb") as stream:
        if stream.read(4) != b"GGUF":
            raise ModelFileError(f"{path}: not a GGUF file, or damaged; {remedy}")
