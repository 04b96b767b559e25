"""Local vision-language models, through llama.cpp: a text GGUF and the mmproj GGUF that belongs to
it, by the chat handlers that llama-cpp-python has. Pictures are small, and may be encoded before
anything is asked about them (pictures.py)."""

import base64
import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from models.errors import ModelFileError
from models.language.gguf_file import refuse_damaged
from models.language.pictures import EncodedPicture, Mtmd
from models.language.reasoning import ReasoningModel

HANDLERS = {
    "mtmd": "MTMDChatHandler",  # by the chat template of the GGUF itself
    "gemma-4": "Gemma4ChatHandler",
    "llama-3-vision": "Llama3VisionAlphaChatHandler",
    "llava-1.5": "Llava15ChatHandler",
    "llava-1.6": "Llava16ChatHandler",
    "minicpm-v-2.6": "MiniCPMv26ChatHandler",
    "moondream": "MoondreamChatHandler",
    "nanollava": "NanoLlavaChatHandler",
    "obsidian": "ObsidianChatHandler",
    "qwen2.5-vl": "Qwen25VLChatHandler",
}
WHOLE_LAST = ("idefics3", "lfm2")
"""Towers that are shown a picture's tiles, then the whole of it."""
YES, NO = ("yes", "Yes", " yes", " Yes", "YES"), ("no", "No", " no", " No", "NO")


class VisionModel(ReasoningModel):
    """A language model that sees. Messages carry images as data URLs. One thread at a time may ask
    it, while another encodes. Raises ModelFileError when the two files or the handler do not go
    together."""

    def __init__(
        self,
        path: Path,
        projector: Path,
        handler: str = "mtmd",
        threads: int = 1,
        context: int = 2048,
        gpu_layers: int = 0,
    ) -> None:
        self._handler, self._mtmd = _handler(projector, handler)
        super().__init__(path, threads, context, gpu_layers, self._handler)
        self._yes, self._no = self._ids(YES), self._ids(NO)
        try:
            self.likes(_blank_question())
        except Exception as error:  # jinja2's, the binding's and our own, all about these files
            self.close()
            reason = " ".join(str(error).split())[:160]
            raise ModelFileError(
                f"{path} with {projector} by handler {handler!r}: cannot see ({reason}); "
                "the projector must be this model's own, and the handler its family's"
            ) from error

    def encode(self, image: bytes) -> EncodedPicture:
        """What its vision tower makes of an image file; seconds, on two cores. Raises
        ModelFileError where it is none."""
        from llama_cpp import llama_model_n_embd_inp

        width = llama_model_n_embd_inp(self._llama.model)
        return self._mtmd.encode(self._handler.mtmd_ctx, image, width)

    def reply(
        self,
        messages: list[dict[str, Any]],
        grammar: str,
        max_tokens: int,
        seconds: float = math.inf,
        pictures: Sequence[EncodedPicture] = (),
    ) -> str:
        """As any does; those `pictures` that the messages show are not encoded again."""
        with self._mtmd.knowing(pictures):
            return super().reply(messages, grammar, max_tokens, seconds)

    def likes(
        self,
        messages: list[dict[str, Any]],
        seconds: float = math.inf,
        pictures: Sequence[EncodedPicture] = (),
    ) -> float:
        """Nats by which the answer is rather yes than no. Raises as `reply` does."""
        from llama_cpp import LogitsProcessorList

        heard: list[float] = []

        def listen(_: Any, logits: Any) -> Any:
            heard.append(_mass(logits, self._yes) - _mass(logits, self._no))
            return logits

        try:
            with self._alarm.after(seconds), self._mtmd.knowing(pictures):
                self._llama.create_chat_completion(
                    messages,
                    max_tokens=1,
                    temperature=0.0,
                    logits_processor=LogitsProcessorList([listen]),
                )
        except (ValueError, RuntimeError) as error:
            raise self._failed(error, seconds) from error
        return heard[0]

    def _ids(self, words: tuple[str, ...]) -> list[int]:
        """The tokens that are one of the words as a whole."""
        split = (self._llama.tokenize(w.encode(), add_bos=False, special=False) for w in words)
        found = sorted({ids[-1] for ids in split if len(ids) == 1})
        if not found:
            raise ModelFileError(f"no token says {words[0]!r}: use style reason")
        return found


def _mass(logits: Any, ids: list[int]) -> float:
    values = np.asarray(logits, np.float64)[ids]
    return float(np.logaddexp.reduce(values))


def _handler(projector: Path, name: str) -> tuple[Any, Mtmd]:
    """The binding's handler, and what it reaches llama.cpp's mtmd by."""
    from llama_cpp import _logger, llama_chat_format, mtmd_cpp

    if name not in HANDLERS:
        raise ModelFileError(f"vision handler {name}: unknown; known are {', '.join(HANDLERS)}")
    if not projector.is_file():
        raise ModelFileError(f"{projector}: no such mmproj file; check the path")
    tower = refuse_damaged(projector)
    # It logs every image to stderr otherwise, whatever `verbose` says.
    mtmd_cpp.mtmd_log_set(_logger.llama_log_callback, None)
    mtmd_cpp.mtmd_helper_log_set(_logger.llama_log_callback, None)
    handler = getattr(llama_chat_format, HANDLERS[name])(str(projector), verbose=False)
    handler._mtmd_cpp = mtmd = Mtmd(mtmd_cpp, whole_last=tower in WHOLE_LAST)
    return handler, mtmd


def _blank_question() -> list[dict[str, Any]]:
    png = cv2.imencode(".png", np.full((32, 32, 3), 128, np.uint8))[1].tobytes()
    url = f"data:image/png;base64,{base64.b64encode(png).decode()}"
    image = {"type": "image_url", "image_url": {"url": url}}
    text = {"type": "text", "text": "Is this picture empty? Answer yes or no."}
    return [{"role": "user", "content": [image, text]}]
