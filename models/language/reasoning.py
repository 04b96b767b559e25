"""Large local language models, through llama.cpp: they reply, by a grammar and in bounded time."""

import ctypes
import math
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from models.errors import ModelFileError, OverdueError
from models.language.gguf import load


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
