"""Pictures for a model that sees, through llama.cpp's mtmd: small ones, encoded once.

A vision tower takes seconds for a picture on two cores, the language model behind it a tenth of
that. So a picture is encoded when there is time, and its vectors are kept; the answer to a question
about it begins with them.
"""

import ctypes
import hashlib
import itertools
import threading
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from models.errors import ModelFileError

TOKENS = 32, 64
"""Of a picture, at least and at most, where its tower can do with fewer."""


@dataclass(frozen=True)
class EncodedPicture:
    """What a vision tower made of an image file: (T, D) float32 vectors, part by part."""

    digest: str  # sha256 of the file
    parts: tuple[NDArray[np.float32], ...] = field(repr=False)

    @property
    def nbytes(self) -> int:
        return sum(part.nbytes for part in self.parts)


@dataclass
class _Cut:
    """What of a conversation's chunks is used: the chunks, which part of its picture each is, and
    how many tokens are left out at the end of a text."""

    chunks: list[Any]
    part: dict[Any, int]
    left_out: dict[Any, int]


class Mtmd:
    """llama.cpp's mtmd as the binding's chat handlers call it, but for three things: it asks for
    few tokens a picture; a picture that is cut into tiles is shown as a whole only, small, where
    `whole_last` says that it follows its tiles; and what is encoded already is not encoded again.

    One thread may ask questions, another encode.
    """

    def __init__(self, mtmd: Any, whole_last: bool) -> None:
        self._mtmd, self._whole_last = mtmd, whole_last
        self._known: dict[str, EncodedPicture] = {}
        self._serial = itertools.count()
        self._cut = _Cut([], {}, {})
        self._encoding = threading.Lock()

    def __getattr__(self, name: str) -> Any:
        return getattr(self._mtmd, name)

    @contextmanager
    def knowing(self, pictures: Sequence[EncodedPicture]) -> Iterator[None]:
        """Have these not encoded again meanwhile."""
        self._known = {picture.digest: picture for picture in pictures}
        try:
            yield
        finally:
            self._known = {}

    def encode(self, context: Any, image: bytes, width: int) -> EncodedPicture:
        """What the tower makes of an image file, vectors of `width`. Raises ModelFileError where it
        is none."""
        data = (ctypes.c_uint8 * len(image)).from_buffer_copy(image)
        bitmap = self.mtmd_helper_bitmap_init_from_buf(context, data, len(image), False)
        if bitmap is None:
            raise ModelFileError("llama.cpp: what should be a picture is none")
        chunks = self._mtmd.mtmd_input_chunks_init()
        try:
            marker, text = self._mtmd.mtmd_default_marker(), self._mtmd.mtmd_input_text()
            text.text, text.text_len, text.parse_special = marker, len(marker), True
            bitmaps = (self._mtmd.mtmd_bitmap_p_ctypes * 1)(bitmap)
            if self._mtmd.mtmd_tokenize(context, chunks, ctypes.byref(text), bitmaps, 1) != 0:
                raise ModelFileError("llama.cpp: a picture cannot be prepared for its tower")
            cut = self._selected(chunks)
            parts = [self._vectors(context, c, width) for c in cut.chunks if c in cut.part]
        finally:
            self._mtmd.mtmd_input_chunks_free(chunks)
            self._mtmd.mtmd_bitmap_free(bitmap)
        return EncodedPicture(_digest(image), tuple(parts))

    def _vectors(self, context: Any, chunk: Any, width: int) -> NDArray[np.float32]:
        with self._encoding:
            if self._mtmd.mtmd_encode_chunk(context, chunk) != 0:
                raise ModelFileError("llama.cpp: a picture cannot be encoded")
            count = self._mtmd.mtmd_input_chunk_get_n_tokens(chunk)
            held = self._mtmd.mtmd_get_output_embd(context)
            return np.ctypeslib.as_array(held, shape=(count, width)).copy()

    # -- what handlers call ----------------------------------------------------------------------

    def mtmd_context_params_default(self) -> Any:
        params = self._mtmd.mtmd_context_params_default()
        params.image_min_tokens, params.image_max_tokens = TOKENS
        return params

    def mtmd_helper_bitmap_init_from_buf(self, context: Any, data: Any, *more: Any) -> Any:
        bitmap = self._mtmd.mtmd_helper_bitmap_init_from_buf(context, data, *more)
        if bitmap is not None:
            name = f"{_digest(bytes(data))}/{next(self._serial)}"  # one may be shown twice
            self._mtmd.mtmd_bitmap_set_id(bitmap, name.encode())
        return bitmap

    def mtmd_tokenize(self, context: Any, chunks: Any, *more: Any) -> int:
        result: int = self._mtmd.mtmd_tokenize(context, chunks, *more)
        self._cut = self._selected(chunks)
        return result

    def mtmd_input_chunks_size(self, chunks: Any) -> int:
        return len(self._cut.chunks)

    def mtmd_input_chunks_get(self, chunks: Any, index: int) -> Any:
        return self._cut.chunks[index]

    def mtmd_input_chunk_get_tokens_text(self, chunk: Any, count: Any) -> Any:
        tokens = self._mtmd.mtmd_input_chunk_get_tokens_text(chunk, count)
        count._obj.value = max(0, count._obj.value - self._cut.left_out.get(chunk, 0))
        return tokens

    def mtmd_helper_eval_chunk_single(
        self, context: Any, llama: Any, chunk: Any, *more: Any
    ) -> int:
        *place, last, after = more
        known = self._known.get(self._picture(chunk).partition("/")[0])
        if known is None:
            with self._encoding:
                whole = self._mtmd.mtmd_helper_eval_chunk_single
                return int(whole(context, llama, chunk, *place, last, after))
        vectors = known.parts[self._cut.part[chunk]]
        data = vectors.ctypes.data_as(ctypes.POINTER(ctypes.c_float))
        nobody = self._mtmd.mtmd_helper_post_decode_callback()
        decode = self._mtmd.mtmd_helper_decode_image_chunk
        return int(decode(context, llama, chunk, data, *place, after, nobody, None))

    # -- tiles -----------------------------------------------------------------------------------

    def _selected(self, chunks: Any) -> _Cut:
        """What of a conversation is used."""
        every = [
            self._mtmd.mtmd_input_chunks_get(chunks, n)
            for n in range(self._mtmd.mtmd_input_chunks_size(chunks))
        ]
        cut, names = _Cut([], {}, {}), [self._picture(chunk) for chunk in every]
        at = 0
        while at < len(every):
            if not names[at]:
                cut.chunks.append(every[at])
                at += 1
                continue
            end = max(n for n, name in enumerate(names) if name == names[at]) + 1
            self._show(cut, every[at:end])
            at = end
        return cut

    def _show(self, cut: _Cut, tiled: Sequence[Any]) -> None:
        """Add one picture's chunks: tiles with their marks in between, or the whole alone."""
        images = [chunk for chunk in tiled if self._picture(chunk)]
        if len(images) > 1 and self._whole_last and sum(map(self._count, images)) > TOKENS[1]:
            marks = [chunk for chunk in tiled if not self._picture(chunk)]
            if len(marks) > 1 and cut.chunks:  # that of the first tile ends the text before it
                cut.left_out[cut.chunks[-1]] = self._count(marks[0])
            tiled, images = [*marks[-1:], images[-1]], images[-1:]
        cut.chunks += tiled
        cut.part |= {chunk: n for n, chunk in enumerate(images)}

    def _count(self, chunk: Any) -> int:
        return int(self._mtmd.mtmd_input_chunk_get_n_tokens(chunk))

    def _picture(self, chunk: Any) -> str:
        """The name of the picture that a chunk is part of, its digest first; "" of a text."""
        if self._mtmd.mtmd_input_chunk_get_type(chunk) == self._mtmd.MTMD_INPUT_CHUNK_TYPE_TEXT:
            return ""
        return (self._mtmd.mtmd_input_chunk_get_id(chunk) or b"").decode()


def _digest(image: bytes) -> str:
    return hashlib.sha256(image).hexdigest()
